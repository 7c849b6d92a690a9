#pragma once

// A rasteriser of our own for plain surfaces: depth, ids and Lambert's shading of one colour an
// instance, without textures, materials, shadows or anything that reaches behind the camera; all
// the rest is drawn by OpenGL (sim/gl_drawer.h), and the pictures are alike. The nearest face of
// each pixel is found first (scenes/face_raster.h), then each pixel is shaded once.

#include <array>
#include <cstdint>
#include <vector>

#include "scenes/camera.h"
#include "scenes/face_raster.h"
#include "sim/renderer.h"

namespace pickbed {

struct RasterInstance {
  Pose X_CO = Pose::Identity();
  bool cull_back = false;         // closed and facing outward
  std::array<float, 3> albedo{};  // red, green, blue, 0..1
  uint16_t id = 0;
};

class CpuRaster {
 public:
  // Starts a picture of a part of the camera's image.
  void Begin(const CameraIntrinsics& camera, const ImageBox& box) {
    camera_ = camera;
    raster_.Begin(camera, box);
  }

  // All of the mesh must be in front of the camera.
  void Draw(const RasterMesh& mesh, const RasterInstance& instance);

  // Either of these ends the picture. Write() leaves pixels that show nothing as they are, and
  // takes images of the camera's size: of depth, and of colour and ids where they are not empty.
  void Write(const Light& light, const Eigen::Vector3d& light_C, RenderedImage& out);
  int CountCovered();

 private:
  CameraIntrinsics camera_;
  FaceRaster raster_;
  std::vector<float> normals_, looks_;  // of a row's pixels
  std::vector<uint32_t> rgba_;
};

}  // namespace pickbed
