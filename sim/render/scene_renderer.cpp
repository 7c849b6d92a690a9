#include "sim/render/renderer.h"
#include "sim/render/visibility.h"

namespace pickbed::sim {

SceneRenderer::SceneRenderer(const ObjectSet& objects, const Bin& bin,
                             const GlContextOptions& options, const DetailOptions& detail)
    : renderer_(options, detail) {
  BinMeshOf(bin);
  for (const auto& object : objects) object_meshes_.push_back(renderer_.AddMesh(object->mesh_O));
}

int SceneRenderer::BinMeshOf(const Bin& bin) {
  for (const auto& [known, mesh] : bin_meshes_) {
    if (known.inner_size_m == bin.inner_size_m && known.wall_m == bin.wall_m &&
        known.shape == bin.shape) {
      return mesh;
    }
  }
  return bin_meshes_.emplace_back(bin, renderer_.AddMesh(BinMesh(bin))).second;
}

std::vector<RenderInstance> SceneRenderer::InstancesOf(const Scene& scene) {
  std::vector<RenderInstance> instances;
  instances.reserve(scene.objects.size() + 1);
  for (const PosedObject& object : scene.objects) {
    instances.push_back({object_meshes_.at(object.object), object.X_WO,
                         static_cast<uint16_t>(object.instance + 1)});
  }
  instances.push_back({BinMeshOf(scene.bin), Pose::Identity(), 0});
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
  return pickbed::sim::VisibleFractions(renderer_, camera, instances, ids);
}

}  // namespace pickbed::sim
