#include "eval/trial/oracle_estimator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/error.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

struct OracleCase {
  Scene scene;
  std::vector<double> visible_fractions;
  Camera camera;

  std::vector<TrueInstance> Instances() const {
    return InstancesOf(scene, visible_fractions, camera.X_CW());
  }
};

OracleCase InstancesInView(const std::vector<double>& visible) {
  OracleCase truth;
  truth.camera.SetPose(LookAt({0.1, -0.2, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
  Rng rng(5);
  for (size_t i = 0; i < visible.size(); ++i) {
    const Pose X_WO = MakePose(rng.Rotation().toRotationMatrix(), 0.1 * rng.UnitVector());
    truth.scene.objects.push_back({InstanceId(i + 10), ObjectId(i % 2), X_WO});
  }
  truth.visible_fractions = visible;
  return truth;
}

TEST(OracleEstimator, WithoutNoisePosesAreExactAndRankedByVisibility) {
  const OracleCase truth = InstancesInView({0.3, 0.9, 0.6});
  Rng rng(1);
  const auto found = OracleEstimate(truth.Instances(), EstimatorSpec(), rng).hypotheses;
  ASSERT_EQ(found.size(), 3u);
  const int order[] = {1, 2, 0};
  for (int i = 0; i < 3; ++i) {
    const PosedObject& posed = truth.scene.objects[order[i]];
    EXPECT_EQ(found[i].object, posed.object);
    EXPECT_EQ(found[i].score, truth.visible_fractions[order[i]]);
    EXPECT_TRUE((truth.camera.X_WC() * found[i].X_CO).isApprox(posed.X_WO, 1e-12));
  }
}

TEST(OracleEstimator, InstancesBelowTenPercentVisibleAreNotReported) {
  const OracleCase truth = InstancesInView({0.0999, 0.1001, 0});
  Rng rng(1);
  const auto found = OracleEstimate(truth.Instances(), EstimatorSpec(), rng).hypotheses;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].score, 0.1001);
}

TEST(OracleEstimator, NoiseHasTheRequestedStandardDeviation) {
  const OracleCase truth = InstancesInView({1});
  const Pose X_CO = truth.camera.X_CW() * truth.scene.objects[0].X_WO;
  EstimatorSpec spec;
  spec.noise_mm = 2;
  spec.noise_deg = 3;
  Rng rng(9);
  constexpr int kDraws = 4000;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero(), sum = squares;
  double angle_squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const auto found = OracleEstimate(truth.Instances(), spec, rng).hypotheses;
    const Eigen::Vector3d error_mm = 1e3 * (found[0].X_CO.translation() - X_CO.translation());
    sum += error_mm;
    squares += error_mm.cwiseAbs2();
    const double angle = RotationAngleRad(X_CO.linear(), found[0].X_CO.linear()) * 180 / M_PI;
    angle_squares += angle * angle;
  }
  // Four standard errors of a mean and of a standard deviation.
  const double tolerance = 4 / std::sqrt(2.0 * kDraws);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / kDraws, 0, 4 * 2 / std::sqrt(kDraws));
    EXPECT_NEAR(std::sqrt(squares[axis] / kDraws), 2, 2 * tolerance);
  }
  EXPECT_NEAR(std::sqrt(angle_squares / kDraws), 3, 3 * tolerance);
}

TEST(OracleEstimator, IsRegisteredAndAMisspellingGetsASuggestion) {
  EXPECT_NO_THROW(RequireEstimator("oracle"));
  try {
    RequireEstimator("orcale");
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'oracle'"));
  }
}

}  // namespace
}  // namespace pickbed::tests
