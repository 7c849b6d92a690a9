#pragma once

// Instances of meshes that our own rasteriser can draw, see sim/cpu_raster.h.

#include <vector>

#include "scenes/mesh_levels.h"
#include "sim/cpu_raster.h"
#include "sim/gl_objects.h"
#include "sim/renderer.h"

namespace pickbed {

class PlainDrawer {
 public:
  // Handles are counted as in GlDrawer.
  void AddMesh(const std::vector<MeshLevel>& levels, const GlMesh& uploaded);

  // Has it one colour only, or is none wanted?
  bool CanDraw(const RenderInstance& instance, bool color) const;

  void Draw(const RenderInstance& instance, int level, const Pose& X_CO);

  // To begin a picture and to end it.
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

}  // namespace pickbed
