#pragma once

// Draws lists of instances with one call per run of equal mesh and level of detail. Private to .cpp
// files of sim, see sim/render/gl_functions.h. The context must be current in every call.

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "scenes/camera/footprint.h"
#include "scenes/geometry/triangle_mesh.h"
#include "sim/render/gl_functions.h"
#include "sim/render/gl_objects.h"
#include "sim/render/gl_programs.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// One instance to draw.
struct Draw {
  int mesh = 0;
  int level = 0;
  double near_m = 0;
  InstanceAttributes attributes;
  std::array<float, 3> light_C{};
  std::optional<std::array<int, 4>> scissor = std::nullopt;  // x, y, width, height in px
};

// Settings of a whole list.
struct DrawSetup {
  unsigned switches = 0;  // ShaderSwitch bits that do not depend on the mesh
  float ambient = 1;
  float diffuse = 0;
  // The remaining fields are for kShadowSwitch.
  GLuint shadow_map = 0;
  std::array<float, 16> shadow_from_C{};  // column-major
  std::array<float, 2> shadow_blur{};
};

// Owns uploaded meshes and draws instances of them.
class GlDrawer {
 public:
  explicit GlDrawer(const GlFunctions& gl);

  int AddMesh(const TriangleMesh& mesh, const std::vector<MeshLevel>& levels);
  const GlMesh& Mesh(int mesh) const { return meshes_.at(mesh); }
  void DrawAll(const std::vector<Draw>& draws, const DrawSetup& setup);
  void DeleteAll();

 private:
  void UploadInstances(const std::vector<Draw>& draws);
  void UseProgramFor(const GlMesh& mesh, const Draw& first, const DrawSetup& setup);

  const GlFunctions& gl_;
  GLuint instance_buffer_ = 0;
  std::vector<GlMesh> meshes_;
  GlPrograms programs_;
  std::vector<InstanceAttributes> attributes_;  // a member to reuse its memory
};

// Groups draws by mesh and level, with the nearer groups first, so that hidden pixels are rejected
// early.
void SortNearFirst(std::vector<Draw>& draws);

// Depth range for the near and far planes, in metres.
struct DepthRange {
  double near_m = std::numeric_limits<double>::infinity();
  double far_m = 0;

  void Include(const Footprint& footprint) {
    near_m = std::min(near_m, std::max(kNearestDrawn_m, 0.999 * footprint.near_m));
    far_m = std::max(far_m, 1.001 * footprint.far_m);
  }
};

// Computes the vertex shader's input for one instance. The image's first pixel is at `corner` of a
// viewport of the given size in px.
InstanceAttributes AttributesOf(const Pose& X_CO, const RenderInstance& instance,
                                const CameraIntrinsics& k, const DepthRange& range,
                                const Eigen::Vector2i& corner, int viewport_width,
                                int viewport_height);

}  // namespace pickbed::sim
