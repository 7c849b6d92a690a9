#include "sim/renderer.h"
#include "sim/visibility.h"

namespace pickbed {

SceneRenderer::SceneRenderer(const ObjectSet& objects, const Bin& bin,
                             const GlContextOptions& options, const DetailOptions& detail)
    : renderer_(options, detail), bin_mesh_(renderer_.AddMesh(BinMesh(bin))) {
  for (const auto& object : objects) object_meshes_.push_back(renderer_.AddMesh(object->mesh_O));
}

std::vector<RenderInstance> SceneRenderer::InstancesOf(const Scene& scene) const {
  std::vector<RenderInstance> instances;
  instances.reserve(scene.objects.size() + 1);
  for (const PosedObject& object : scene.objects) {
    instances.push_back({object_meshes_.at(object.object), object.X_WO,
                         static_cast<uint16_t>(object.instance + 1)});
  }
  return instances;
}

RenderedImage SceneRenderer::Render(const Scene& scene, const Camera& camera, const Light& light) {
  std::vector<RenderInstance> instances = InstancesOf(scene);
  instances.push_back({bin_mesh_, Pose::Identity(), 0});
  return renderer_.Render(camera, instances, light);
}

std::vector<double> SceneRenderer::VisibleFractions(const Scene& scene, const Camera& camera,
                                                    const Image<uint16_t>& ids) {
  return pickbed::VisibleFractions(renderer_, camera, InstancesOf(scene), ids);
}

}  // namespace pickbed
