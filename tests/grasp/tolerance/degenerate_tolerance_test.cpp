// Tolerance models of meshes without area, and of samples that determine few of their weights.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "grasp/tolerance/model_files.h"
#include "grasp/tolerance/tolerance_model.h"
#include "scenes/geometry/decompositions.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

PoseOffset OffsetOf(const Vector3d& position_m, const Vector3d& rotation_rad) {
  PoseOffset offset;
  offset << position_m, rotation_rad;
  return offset;
}

TEST(DegenerateTolerance, OffsetsWithoutRotationAndOfHalfATurn) {
  EXPECT_TRUE(ToPose(PoseOffset::Zero()).matrix().isIdentity(0));
  EXPECT_TRUE(ToPoseOffset(Pose::Identity()).isZero(0));
  const Vector3d p(0.1, -0.2, 0.3);
  for (const double angle_rad : {0.0, 1e-300, 1e-160, 1e-12, std::numbers::pi}) {
    for (int axis = 0; axis < 3; ++axis) {
      const PoseOffset offset = OffsetOf(p, angle_rad * Vector3d::Unit(axis));
      const Pose X = ToPose(offset);
      EXPECT_TRUE((X.linear() * X.linear().transpose()).isIdentity(1e-12)) << angle_rad;
      const PoseOffset again = ToPoseOffset(X);
      EXPECT_EQ(again.head<3>(), p);
      EXPECT_NEAR(again.tail<3>().norm(), angle_rad, 1e-12) << "may be about the opposite axis";
      EXPECT_NEAR((ToPose(again).linear() - X.linear()).norm(), 0, 1e-12);
    }
  }
}

TEST(DegenerateTolerance, AMeshWithoutAreaHasNoModel) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    ObjectModel object;
    object.mesh_O = test.mesh;
    const auto make = [&] { return EmptyToleranceModel(object, "jaw", {Pose::Identity()}); };
    if (!test.has_area) {
      EXPECT_THAT(ErrorOf([&] { make(); }), testing::HasSubstr("a mesh without area")) << test.name;
      continue;
    }
    const ToleranceModel model = make();
    const Bounds bounds = MeshBounds(test.mesh);
    const double size_m = bounds.size().norm(), far_m = bounds.center().norm() + size_m;
    EXPECT_LE((model.surface_mean_O - bounds.center()).norm(), size_m) << test.name;
    const auto spread = EigenOfSymmetric3(model.surface_covariance_O);
    EXPECT_GE(spread.values[0], -1e-12 * far_m * far_m) << test.name;
    EXPECT_LE(spread.values[2], size_m * size_m + 1e-12 * far_m * far_m) << test.name;
    EXPECT_TRUE(test.has_volume || spread.values[0] < 1e-12 * far_m * far_m)
        << test.name << ": flat meshes do not spread along their normal";
    // A motion moves the surface, so that the identity is the nearest error of the true pose.
    EXPECT_EQ(SuccessProbability(model, Pose::Identity()), 0.5) << "all weights are zero";
  }
}

TEST(DegenerateTolerance, WithoutSymmetriesTheErrorIsTheNearest) {
  const std::vector<Pose> inverses = InverseSymmetries({});
  ASSERT_EQ(inverses.size(), 1u);
  EXPECT_TRUE(inverses[0].matrix().isIdentity(0));
  const auto box = BoxObject({0.04, 0.03, 0.02}, 0.1);
  ObjectModel plain = *box;
  plain.symmetries_O = {};
  const ToleranceModel model = EmptyToleranceModel(plain, "jaw", {Pose::Identity()});
  const Pose X_OE = FromAbove({0.01, 0.02, 0.03}, 0.4);
  EXPECT_EQ(NearestError(model, X_OE).matrix(), X_OE.matrix());
  EXPECT_EQ(NearestError(model, Pose::Identity()).matrix(), Pose::Identity().matrix());
}

// One sample, equal ones, samples on a line, and samples of one outcome leave most weights open.
TEST(DegenerateTolerance, FewSamplesGiveFiniteWeights) {
  const auto box = BoxObject({0.04, 0.03, 0.02}, 0.1);
  std::vector<ToleranceSample> on_a_line;
  for (int i = 0; i < 40; ++i) {
    on_a_line.push_back({OffsetOf({0.0005 * i, 0, 0}, Vector3d::Zero()), i < 20, i % 4});
  }
  const ToleranceSample held{OffsetOf({0.001, 0, 0}, Vector3d::Zero()), true, 0};
  const ToleranceSample lost{OffsetOf({0.001, 0, 0}, Vector3d::Zero()), false, 7};
  std::vector<ToleranceSample> both(30, held);
  both.resize(60, lost);
  struct {
    std::vector<ToleranceSample> samples;
    double low, high;  // of the probability at the samples' place
  } const cases[] = {
      {{held}, 0.5, 1},
      {{lost}, 0, 0.5},
      {std::vector<ToleranceSample>(50, held), 0.9, 1},
      {std::vector<ToleranceSample>(50, lost), 0, 0.1},
      {both, 0.4, 0.6},
      {on_a_line, 0.7, 1},
  };
  for (const auto& test : cases) {
    ToleranceModel model = EmptyToleranceModel(*box, "jaw", {Pose::Identity()});
    FitTolerance(test.samples, {}, model);
    ASSERT_EQ(model.weights.size(), ToleranceTerms().size());
    for (const double weight : model.weights) ASSERT_TRUE(std::isfinite(weight));
    const double here = SuccessProbability(model, ToPose(held.error_G), Pose::Identity());
    EXPECT_TRUE(here >= test.low && here <= test.high) << here;
    for (const double far_m : {0.1, 1e3}) {
      const double there = SuccessProbability(model, Translation({far_m, -far_m, far_m}));
      EXPECT_TRUE(there >= 0 && there <= 1) << there;
    }
    const double certain = ExpectedSuccess(model, *box, Pose::Identity(), {0, 0});
    EXPECT_NEAR(certain, SuccessProbability(model, Pose::Identity(), Pose::Identity()), 1e-9);
  }
}

}  // namespace
}  // namespace pickbed::tests
