#include "eval/trial/estimator_runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

// A reported pose must be above the bin floor and between the walls.
TEST(RemoveOutsideBin, RemovesPosesBesideOrBelowTheBin) {
  ScenarioSpec spec = CubeScenario(1);
  spec.bin.inner_size_m = {0.4, 0.3, 0.15};
  const SimulatedCell cell(spec, EasyCube());
  const auto at = [&](const Eigen::Vector3d& p_W) {
    return PoseHypothesis{ObjectId{0}, cell.camera().X_CW() * Translation(p_W), 0.9, {}};
  };
  const std::vector<Eigen::Vector3d> inside{{0, 0, 0.015}, {0.185, 0.135, 0.015}, {-0.185, 0, 0.3}};
  const std::vector<Eigen::Vector3d> outside{
      {0.26, 0, 0.1}, {0, -0.18, 0.15}, {-0.21, 0.16, 0.015}, {0, 0, -0.02}};
  std::vector<PoseHypothesis> hypotheses;
  for (size_t i = 0; i < outside.size(); ++i) {
    hypotheses.push_back(at(outside[i]));
    if (i < inside.size()) hypotheses.push_back(at(inside[i]));
  }
  RemoveOutsideBin(cell, {cell.camera(), std::nullopt}, hypotheses);
  ASSERT_EQ(hypotheses.size(), inside.size());
  for (size_t i = 0; i < inside.size(); ++i) {
    EXPECT_TRUE(
        (cell.camera().X_WC() * hypotheses[i].X_CO).translation().isApprox(inside[i], 1e-9));
  }
}

// The error names a focal length and a distance that are enough, also after rounding.
TEST(EstimatorRunner, RefusesObjectsThatTheCameraShowsTooSmall) {
  ScenarioSpec spec = CubeScenario(1);
  spec.estimator.name = "ppf";
  spec.camera.focal_px = 40;
  const auto make = [&] {
    const SimulatedCell cell(spec, EasyCube());
    EstimatorRunner(cell, spec, 1, {});
  };
  const std::string error = ErrorOf(make);
  EXPECT_THAT(error, testing::StartsWith("camera.eye_m"));
  EXPECT_THAT(error, testing::HasSubstr("'cube' is "));
  const std::string key = "camera.focal_px=";
  ASSERT_NE(error.find(key), std::string::npos);
  const std::string offer = "to a distance of ";
  ASSERT_NE(error.find(offer), std::string::npos);
  const double near_m = std::stod(error.substr(error.find(offer) + offer.size()));
  EXPECT_GE(EasyCube().front()->diameter_m * spec.camera.focal_px / near_m, 20);
  EXPECT_LT(EasyCube().front()->diameter_m * spec.camera.focal_px / (near_m + 0.01), 20);
  spec.camera.focal_px = std::stod(error.substr(error.find(key) + key.size()));
  make();
}

}  // namespace
}  // namespace pickbed::tests
