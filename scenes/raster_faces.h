#pragma once

// The nearest triangle of each pixel: the inner loop of scenes/face_raster.h.

#include <array>
#include <cstddef>

namespace pickbed {

constexpr int kSubpixels = 256;     // outlines are rounded to this share of a pixel, as in Mesa
constexpr int kAttributes = 4;      // of a vertex: 1 / z, normal / z
constexpr int kRasterPadding = 16;  // px at the end of a row that may be written without effect

// A face that is drawn. Of the attributes: value at the target's first pixel, change by a column
// and by a row. Then red, green, blue and id. One cache line.
struct alignas(64) RasterFace {
  std::array<float, 4> at_origin, by_column, by_row, look;
};

// All are in front of the camera.
struct ScreenVertices {
  const float *x, *y;                // px
  const int *snapped_x, *snapped_y;  // px / kSubpixels
  const float* attributes;           // kAttributes each
};

struct RasterTriangles {
  const std::array<int, 3>* corners;
  int count;
  bool cull_back;
  const float* normals;  // one and the normal of each, or null for those of the vertices
};

struct RasterTarget {
  int width, height;
  int pitch;                    // px from row to row, padding included
  float* inverse_depth;         // 1/m, 0 = nothing
  int* face_at;                 // number of the face that is nearest
  std::array<int, 2>* touched;  // of each row: first column, column past the last
};

// Numbers those that may be seen from `index` on, writes them to `faces`, which has room for all,
// and returns the next number.
int FillFaces(const ScreenVertices& vertices, const RasterTriangles& triangles,
              const std::array<float, 4>& look, const RasterTarget& target, int index,
              RasterFace* faces);

}  // namespace pickbed
