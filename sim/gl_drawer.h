#pragma once

// Draws lists of instances, a call for each run of one mesh and level of detail. Private to sim's
// .cpp files, see sim/gl_functions.h. Every call needs the context to be current.

#include <array>
#include <optional>
#include <vector>

#include "scenes/triangle_mesh.h"
#include "sim/gl_functions.h"
#include "sim/gl_objects.h"
#include "sim/gl_programs.h"

namespace pickbed {

// One instance to draw.
struct Draw {
  int mesh = 0;
  int level = 0;
  double near_m = 0;
  InstanceAttributes attributes;
  std::array<float, 3> light_C{};
  std::optional<std::array<int, 4>> scissor = std::nullopt;  // x, y, width, height in px
};

// What holds for a whole list.
struct DrawSetup {
  unsigned switches = 0;  // those of ShaderSwitch that do not follow from the mesh
  float ambient = 1;
  float diffuse = 0;
  // For kShadowSwitch:
  GLuint shadow_map = 0;
  std::array<float, 16> shadow_from_C{};  // column by column
  std::array<float, 2> shadow_blur{};
};

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
  std::vector<InstanceAttributes> attributes_;  // memory that is kept between lists
};

// Groups of one mesh and level, the nearer groups first so that the bin hides nothing's work.
void SortNearFirst(std::vector<Draw>& draws);

}  // namespace pickbed
