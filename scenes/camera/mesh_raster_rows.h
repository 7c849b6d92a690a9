#pragma once

// Inner loop of scenes/camera/mesh_raster.h: finds the nearest triangle of each pixel.

#include <array>
#include <cstddef>

namespace pickbed::scenes {

constexpr int kSubpixels = 256;     // outlines are rounded to 1/256 of a pixel, as in Mesa
constexpr int kAttributes = 4;      // values per vertex: 1 / z and the three of normal / z
constexpr int kRasterPadding = 16;  // px at the end of a row that may be written without effect

// A drawn face: attribute values at the target's first pixel and their change per column and per
// row. `attributes` is red, green, blue and id. The struct fills one cache line.
struct alignas(64) RasterFace {
  std::array<float, 4> at_origin, by_column, by_row, attributes;
};

// Projected vertices; all must be in front of the camera.
struct ScreenVertices {
  const float *x, *y;                // px
  const int *snapped_x, *snapped_y;  // in units of 1/256 px
  const float* attributes;           // kAttributes values per vertex
};

// Triangles of a mesh as vertex indices.
struct RasterTriangles {
  const std::array<int, 3>* corners;
  int count;
  bool cull_back;
  const float* normals;  // (1, normal) of each triangle; null = use the vertices' normals
};

// The arrays that are drawn into.
struct RasterTarget {
  int width, height;            // px
  int pitch;                    // px from row to row, including the padding
  float* inverse_depth;         // 1/m, 0 = no face
  int* face_at;                 // index of the nearest face
  std::array<int, 2>* touched;  // of each row: first column, column past the last
};

// Draws the triangles into `target`. Each face that may be visible gets the next index, starting at
// `index`, and is written to `faces`, which must have room for all triangles. Returns the next free
// index.
int FillFaces(const ScreenVertices& vertices, const RasterTriangles& triangles,
              const std::array<float, 4>& attributes, const RasterTarget& target, int index,
              RasterFace* faces);

// Compiler attributes for loops over pixels, for use in .cpp files only.
//
// The compiler makes versions of the same arithmetic for processors with wider vectors.
// CMakeLists.txt makes it round each product and sum separately, so that all versions give the same
// results.

#define PICKBED_WIDTHS __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
// Inlined, so that a clone does not call code that was compiled for narrower vectors.
#define PICKBED_INLINE inline __attribute__((always_inline))

// Four floats of an array; every x86-64 has instructions for them. clang ignores the alignment of a
// type that `using` names.
typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));

}  // namespace pickbed::scenes
