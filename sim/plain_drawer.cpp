#include "sim/plain_drawer.h"

namespace pickbed {

void PlainDrawer::AddMesh(const std::vector<MeshLevel>& levels, const GlMesh& uploaded) {
  Mesh mesh;
  mesh.one_color = !uploaded.texture && !uploaded.colored_vertices;
  mesh.cull_back = uploaded.cull_back;
  mesh.color = uploaded.base_color;
  for (const MeshLevel& level : levels) mesh.levels.emplace_back(level.mesh);
  meshes_.push_back(std::move(mesh));
}

bool PlainDrawer::CanDraw(const RenderInstance& instance, bool color) const {
  if (!color) return true;
  const Material& material = instance.material;
  return meshes_.at(instance.mesh).one_color && material.gloss == 0 && material.grain == 0;
}

void PlainDrawer::Draw(const RenderInstance& instance, int level, const Pose& X_CO) {
  const Mesh& mesh = meshes_.at(instance.mesh);
  RasterInstance drawn{X_CO, mesh.cull_back, mesh.color, instance.id};
  for (int k = 0; k < 3; ++k) drawn.albedo[k] *= static_cast<float>(instance.material.tint[k]);
  raster_.Draw(mesh.levels.at(level), drawn);
}

}  // namespace pickbed
