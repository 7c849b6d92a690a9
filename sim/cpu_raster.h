#pragma once

// A rasteriser of our own for plain surfaces: depth, ids and Lambert's shading of one colour an
// instance, without textures, materials, shadows or anything that reaches behind the camera. For
// the triangles of few pixels that parts are made of it is several times as fast as llvmpipe, which
// draws all the rest (sim/gl_drawer.h). The pictures are alike: outlines are rounded to 1/256 of a
// pixel, a pixel on an edge belongs to the face below it or to its right, shading is the same.
//
// The nearest face of each pixel is found first; then each pixel is shaded once, from the face's
// attributes over depth, which are linear in the image (Heckbert and Moreton, "Interpolation for
// Polygon Texture Mapping and Shading", 1991).

#include <array>
#include <cstdint>
#include <vector>

#include "scenes/camera.h"
#include "scenes/triangle_mesh.h"
#include "sim/footprint.h"
#include "sim/raster_faces.h"
#include "sim/renderer.h"

namespace pickbed {

// A mesh, coordinate by coordinate.
struct RasterMesh {
  explicit RasterMesh(const TriangleMesh& mesh);
  std::array<std::vector<float>, 3> position_O;  // m
  std::array<std::vector<float>, 3> normal_O;    // of vertices, or of triangles if flat
  std::vector<std::array<int, 3>> triangles;
  bool flat = false;
};

struct RasterInstance {
  Pose X_CO = Pose::Identity();
  bool cull_back = false;         // closed and facing outward
  std::array<float, 3> albedo{};  // red, green, blue, 0..1
  uint16_t id = 0;
};

class CpuRaster {
 public:
  // Starts a picture of a part of the camera's image.
  void Begin(const CameraIntrinsics& camera, const ImageBox& box);

  // All of the mesh must be in front of the camera.
  void Draw(const RasterMesh& mesh, const RasterInstance& instance);

  // Either of these ends the picture. Write() leaves pixels that show nothing as they are, and
  // takes images of the camera's size: of depth, and of colour and ids where they are not empty.
  void Write(const Light& light, const Eigen::Vector3d& light_C, RenderedImage& out);
  int CountCovered();

 private:
  void Project(const RasterMesh& mesh, const Pose& X_CO);
  void Clean();

  // Memory is kept from picture to picture.
  CameraIntrinsics camera_;
  ImageBox box_;
  int pitch_ = 0;                            // of the two below
  std::vector<float> inverse_depth_;         // 1/m of what is nearest, 0 = nothing
  std::vector<int> face_at_;                 // which face that is
  std::vector<std::array<int, 2>> touched_;  // of each row: first column, column past the last
  std::vector<float> screen_x_, screen_y_;   // of vertices, px of the box
  std::vector<int> snapped_x_, snapped_y_;   // 1/256 px
  std::vector<float> over_depth_;            // of vertices: 1 / z, normal / z
  std::vector<float> face_normals_;          // of a flat mesh: 1, normal
  std::vector<RasterFace> faces_;
  int face_count_ = 0;
  std::vector<float> normals_, looks_;  // of a row's pixels
  std::vector<uint32_t> rgba_;
};

}  // namespace pickbed
