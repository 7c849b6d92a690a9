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
  instances.push_back({bin_mesh_, Pose::Identity(), 0});
  return instances;
}

RenderedImage SceneRenderer::Render(const Scene& scene, const Camera& camera, const Light& light,
                                    const RenderOutputs& outputs) {
  return renderer_.Render(camera, InstancesOf(scene), light, outputs);
}

std::vector<RenderedImage> SceneRenderer::RenderCameras(const Scene& scene,
                                                        std::span<const Camera> cameras,
                                                        const Light& light,
                                                        const RenderOutputs& outputs) {
  return renderer_.RenderCameras(cameras, InstancesOf(scene), light, outputs);
}

std::vector<double> SceneRenderer::VisibleFractions(const Scene& scene, const Camera& camera,
                                                    const Image<uint16_t>& ids) {
  std::vector<RenderInstance> instances = InstancesOf(scene);
  instances.pop_back();
  return pickbed::VisibleFractions(renderer_, camera, instances, ids);
}

}  // namespace pickbed
