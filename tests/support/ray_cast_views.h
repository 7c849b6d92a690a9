#pragma once

// View source for tests of training: ray-cast views of objects, without renderer and physics. A
// clutter scene is three instances side by side in a bin that is out of view.

#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "scenes/labelled_view.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

class RayCastViews : public LabelledViewSource {
 public:
  static constexpr double kDistanceM = 0.5;  // from the camera to the instances of a clutter scene

  explicit RayCastViews(ObjectSet objects, double noise_sigma_m = 0.0005)
      : objects_(std::move(objects)), noise_sigma_m_(noise_sigma_m) {}

  const ObjectSet& objects() const override { return objects_; }
  std::vector<LabelledView> Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                     const CameraIntrinsics& camera, uint64_t seed) override;
  std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override;
  std::string IsolatedSettings() const override {
    return "ray cast, noise " + std::to_string(noise_sigma_m_);
  }
  std::string ClutterSceneSettings() const override { return IsolatedSettings(); }

  int isolated_calls() const { return isolated_calls_; }

 private:
  LabelledView Observation(const CameraIntrinsics& camera, std::vector<LabelledInstance> instances,
                           Rng& rng) const;

  ObjectSet objects_;
  double noise_sigma_m_;
  int isolated_calls_ = 0;
};

// Returns a bin far around the instances, which removes none of their pixels.
KnownBackground OutOfSightBin();

}  // namespace pickbed::tests
