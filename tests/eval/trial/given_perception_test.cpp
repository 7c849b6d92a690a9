// Ground truth in place of perception, in a cell whose camera has errors.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "eval/trial/attempt.h"
#include "eval/trial/trial_setup.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

ScenarioSpec WithCameraErrors() {
  ScenarioSpec spec = CubeScenario(1);
  spec.cell.depth_bias_mm = 20;
  spec.cell.depth_scale_percent = spec.cell.focal_percent = 1;
  spec.cell.principal_px = 3;
  spec.cell.hand_eye_mm = 2;
  return spec;
}

TEST(GivenPerception, CameraIsExactIfAllOfPerceptionIsGiven) {
  const BinIndex bin{0};
  SimulatedCell plain(CubeScenario(1), EasyCube());
  const Scene scene = plain.MakeScene(bin).scene;
  const Observation exact = plain.Capture(scene, bin, 0);
  for (const bool all : {true, false}) {
    TrialOptions options;
    options.truth = {all, true, true, true, false};
    TrialSetup setup(WithCameraErrors(), EasyCube(), {}, options);
    const Observation view = setup.cell.Capture(scene, bin, 0);
    EXPECT_EQ(view.frame.depth_m == exact.frame.depth_m, all);
    EXPECT_EQ(view.frame.intrinsics == exact.frame.intrinsics, all);
    EXPECT_FALSE(view.calibration.camera.X_WC().isApprox(exact.calibration.camera.X_WC(), 1e-6));
  }
}

// A pose that contradicted the image would put measured points of an instance beside its model.
TEST(GivenPerception, SubstitutedPosesAreWhereTheImageShowsThem) {
  const BinIndex bin{0};
  TrialOptions options;
  options.truth = {false, true, true, true, false};
  TrialSetup setup(WithCameraErrors(), EasyCube(), {}, options);
  const Scene scene = setup.cell.MakeScene(bin).scene;
  const Observation view = setup.cell.Capture(scene, bin, 0);
  const Pose X_CW = setup.cell.camera().X_CW();
  const InstanceMatcher truth(setup.metric_models,
                              InstancesOf(scene, view.visible_fractions, X_CW));
  const EstimateResult estimate = EstimateInImage(setup, view, truth, bin, 0);
  ASSERT_EQ(estimate.hypotheses.size(), 1u);
  const auto nearest_m = [&](const Pose& X_CO) {
    double depth_m = 10;
    for (const Eigen::Vector3d& p_O : setup.cell.objects()[0]->mesh_O.vertices) {
      depth_m = std::min(depth_m, (X_CO * p_O).z());
    }
    return depth_m;
  };
  std::vector<float> measured_m;
  for (size_t i = 0; i < view.ids.pixels().size(); ++i) {
    const float depth_m = view.frame.depth_m.pixels()[i];
    if (view.ids.pixels()[i] > 0 && depth_m > 0) measured_m.push_back(depth_m);
  }
  ASSERT_GT(measured_m.size(), 300u);
  // The nearest points, without single wrong readings of the sensor.
  const auto near = measured_m.begin() + static_cast<std::ptrdiff_t>(measured_m.size() / 20);
  std::nth_element(measured_m.begin(), near, measured_m.end());
  EXPECT_NEAR(nearest_m(estimate.hypotheses[0].X_CO), *near, 0.002);
  EXPECT_GT(std::abs(nearest_m(truth.instances()[0].X_CO) - *near), 0.005);
}

}  // namespace
}  // namespace pickbed::tests
