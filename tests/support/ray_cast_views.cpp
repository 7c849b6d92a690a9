#include "tests/support/ray_cast_views.h"

#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {

LabelledView RayCastViews::Observation(const CameraIntrinsics& camera,
                                       std::vector<LabelledInstance> instances, Rng& rng) const {
  LabelledView view;
  view.ids = Image<uint16_t>(camera.width(), camera.height());
  SyntheticDepth all(camera);
  for (size_t i = 0; i < instances.size(); ++i) {
    // Pixels that change belong to this instance.
    const Image<float> before = all.frame().depth_m;
    all.AddMesh(objects_[instances[i].object]->mesh_O, instances[i].X_CO);
    for (size_t p = 0; p < before.size(); ++p) {
      if (all.frame().depth_m.pixels()[p] != before.pixels()[p]) {
        view.ids.pixels()[p] = static_cast<uint16_t>(i + 1);
      }
    }
  }
  view.instances = std::move(instances);
  view.frame = WithNoise(all.frame(), noise_sigma_m_, rng);
  return view;
}

std::vector<LabelledView> RayCastViews::Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                                 const CameraIntrinsics& camera, uint64_t seed) {
  ++isolated_calls_;
  std::vector<LabelledView> views;
  for (size_t i = 0; i < X_CO.size(); ++i) {
    Rng rng = Rng::Derive(seed, i, "isolated");
    views.push_back(Observation(camera, {{object, X_CO[i], 1.0}}, rng));
  }
  return views;
}

std::vector<LabelledView> RayCastViews::ClutterScene(const ClutterSceneRequest& request) {
  Rng rng(request.seed);
  std::vector<LabelledView> result;
  for (int i = 0; i < request.views; ++i) {
    std::vector<LabelledInstance> instances;
    for (int k = 0; k < 3; ++k) {
      // Side by side, so that no instance occludes another.
      const Eigen::Vector3d p_C(0.08 * (k - 1), rng.Uniform(-0.03, 0.03), kDistanceM);
      const Pose X_CO = MakePose(rng.Rotation().toRotationMatrix(), p_C);
      instances.push_back({ObjectId(rng.Index(static_cast<int>(objects_.size()))), X_CO, 1.0});
    }
    result.push_back(Observation(SmallCamera(), std::move(instances), rng));
    result.back().background = OutOfSightBin();
  }
  return result;
}

KnownBackground OutOfSightBin() {
  KnownBackground background;
  background.bin.inner_size_m = {5, 5, 5};
  background.X_CB = Translation({0, 0, -1});
  return background;
}

}  // namespace pickbed::tests
