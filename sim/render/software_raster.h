#pragma once

// Software rasterizer for plain surfaces: depth, ids and Lambertian shading with one color per
// instance. It supports no textures, materials, shadows, or meshes that extend behind the camera.
// OpenGL draws those (sim/render/gl_drawer.h), with equivalent images. The nearest face of each
// pixel is found first (scenes/camera/mesh_raster.h); then each pixel is shaded once.

#include <array>
#include <cstdint>
#include <vector>

#include "scenes/camera/camera.h"
#include "scenes/camera/mesh_raster.h"
#include "scenes/geometry/mesh_levels.h"
#include "sim/render/gl_objects.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// One instance to rasterize.
struct RasterInstance {
  Pose X_CO = Pose::Identity();
  bool cull_back = false;         // closed and oriented outward
  std::array<float, 3> albedo{};  // red, green, blue, 0..1
  uint16_t id = 0;
};

// Rasterizes and shades one image at a time.
class CpuRaster {
 public:
  // Starts an image of a part of the camera's image.
  void Begin(const CameraIntrinsics& camera, const ImageBox& box) {
    camera_ = camera;
    raster_.Begin(camera, box);
  }

  // All of the mesh must be in front of the camera.
  void Draw(const RasterMesh& mesh, const RasterInstance& instance);

  // Write() and CountCovered() end the image. Write() fills images of the camera's size: depth, and
  // color and ids if they are not empty. Pixels without a surface are not changed. `light_C` is the
  // light's position in the camera frame.
  void Write(const Light& light, const Eigen::Vector3d& light_C, RenderedImage& out);
  int CountCovered();

 private:
  CameraIntrinsics camera_;
  FaceRaster raster_;
  std::vector<float> normals_, attributes_;  // of one row's pixels
  std::vector<uint32_t> rgba_;
};

// Draws instances of plain meshes with the software rasterizer.

class PlainDrawer {
 public:
  // Handles are the same as in GlDrawer.
  void AddMesh(const std::vector<MeshLevel>& levels, const GlMesh& uploaded);

  // Returns whether the surface has a single color, or no color is requested.
  bool CanDraw(const RenderInstance& instance, bool color) const;

  void Draw(const RenderInstance& instance, int level, const Pose& X_CO);

  // Used to begin and end an image.
  CpuRaster& raster() { return raster_; }

 private:
  struct Mesh {
    bool one_color = false;
    bool cull_back = false;
    std::array<float, 3> color{};
    std::vector<RasterMesh> levels;
  };
  std::vector<Mesh> meshes_;
  CpuRaster raster_;
};

}  // namespace pickbed::sim
