#include "grasp/completed/rehearsal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kSide_m = 0.03;
const Pose kPose = OnFloor(0.02, -0.01, kSide_m, 0);

// A cube of 30 mm. Matter has this `probability` up to 15 mm beside it, along x.
OccupancyShape CubeBesidePossibleMatter(float probability) {
  return ShapeOfBody(0.09, 60, kPose, [&](const Vector3d& p) -> double {
    if ((p.cwiseAbs().array() - 0.5 * kSide_m).maxCoeff() < 0) return 1;
    const bool is_beside = std::abs(p.x()) < 0.03 && std::abs(p.y()) < 0.5 * kSide_m &&
                           std::abs(p.z()) < 0.5 * kSide_m;
    return is_beside ? probability : 0;
  });
}

Grasp AcrossX(const Vector3d& tips_W, double width_m = kSide_m) {
  Grasp grasp;
  grasp.X_WG = FromAbove(tips_W);
  grasp.width_m = width_m;
  return grasp;
}

class RehearsalTest : public ::testing::Test {
 protected:
  Rehearsal Of(const std::vector<OccupancyShape>& shapes,
               const Eigen::Vector2d& levels = RehearsalOptions().surface_levels) const {
    RehearsalOptions options;
    options.surface_levels = levels;
    return Rehearsal(shapes, Pose::Identity(), assumed_, Bin().friction, options);
  }
  const CompletedObjectOptions assumed_{
      .surface_level = 0.45, .density_kgpm3 = 1500, .friction = 0.4};
  const ParallelJaw jaw_ = SmallJaw();
  // Tips 5 mm above the floor, at the center of the cube.
  const Grasp centered_ = AcrossX({0.02, -0.01, 0.005});
};

TEST_F(RehearsalTest, HoldsACubeThroughItsCenter) {
  const std::vector<OccupancyShape> shapes{BoxShape(Vector3d::Constant(kSide_m), kPose)};
  Rehearsal rehearsal = Of(shapes);
  const auto failures = rehearsal.FailuresOf(centered_, jaw_);
  ASSERT_TRUE(failures);
  EXPECT_EQ(failures->hit, 0);
  EXPECT_EQ(failures->lost, 0);
}

// A finger that is 20 mm beside its place comes down on the cube.
TEST_F(RehearsalTest, AFingerOverTheObjectHitsIt) {
  const std::vector<OccupancyShape> shapes{BoxShape(Vector3d::Constant(kSide_m), kPose)};
  Rehearsal rehearsal = Of(shapes);
  const Grasp aside = AcrossX({0.04, -0.01, 0.005});
  EXPECT_EQ(rehearsal.FailureOf(aside, jaw_, 0, 0.45), FailureReason::kCollision);
  EXPECT_EQ(rehearsal.FailuresOf(aside, jaw_).value().hit, 1);
}

// At the lower level the fingers meet matter that the higher one does not have.
TEST_F(RehearsalTest, EachLevelIsRehearsed) {
  const std::vector<OccupancyShape> shapes{CubeBesidePossibleMatter(0.4f)};
  Rehearsal rehearsal = Of(shapes);
  EXPECT_EQ(rehearsal.FailureOf(centered_, jaw_, 0, 0.3), FailureReason::kCollision);
  EXPECT_EQ(rehearsal.FailureOf(centered_, jaw_, 0, 0.45), FailureReason::kNone);
  EXPECT_EQ(rehearsal.FailuresOf(centered_, jaw_).value().hit, 0.5);
}

// No surface at the higher level: only the lower one counts.
TEST_F(RehearsalTest, ALevelWithoutAnObjectDoesNotCount) {
  OccupancyShape unsure = BoxShape(Vector3d::Constant(kSide_m), kPose);
  for (float& probability : unsure.occupancy) probability *= 0.4f;
  const std::vector<OccupancyShape> shapes{unsure};
  Rehearsal rehearsal = Of(shapes);
  EXPECT_EQ(rehearsal.FailureOf(centered_, jaw_, 0, 0.45), FailureReason::kClosedOnNothing);
  EXPECT_EQ(rehearsal.FailuresOf(centered_, jaw_).value().lost, 0);
  Rehearsal higher = Of(shapes, {0.45, 0.45});
  EXPECT_FALSE(higher.FailuresOf(centered_, jaw_));
}

TEST_F(RehearsalTest, NeedsAShapeBetweenTheFingers) {
  const std::vector<OccupancyShape> shapes{
      BoxShape(Vector3d::Constant(kSide_m), OnFloor(-0.1, 0.1, kSide_m, 0)),
      BoxShape(Vector3d::Constant(kSide_m), kPose)};
  Rehearsal rehearsal = Of(shapes);
  EXPECT_EQ(rehearsal.ShapeBetween(centered_, jaw_), 1);
  const Grasp nowhere = AcrossX({0.1, 0.1, 0.005});
  EXPECT_EQ(rehearsal.ShapeBetween(nowhere, jaw_), -1);
  EXPECT_FALSE(rehearsal.FailuresOf(nowhere, jaw_));
}

// The object weighs 13 times as much and has little friction.
TEST_F(RehearsalTest, AHeavySlipperyObjectSlips) {
  const std::vector<OccupancyShape> shapes{BoxShape(Vector3d::Constant(kSide_m), kPose)};
  const CompletedObjectOptions assumed{
      .surface_level = 0.45, .density_kgpm3 = 20000, .friction = 0.05};
  Rehearsal heavy(shapes, Pose::Identity(), assumed, Bin().friction);
  EXPECT_EQ(heavy.FailureOf(centered_, jaw_, 0, 0.45), FailureReason::kSlipped);
  EXPECT_EQ(heavy.FailuresOf(centered_, jaw_).value().lost, 1);
}

// The shape ends 20 mm above the floor, as if its lower half were missing. The tips reach below it.
TEST_F(RehearsalTest, ThePlaneIsBelowTheHand) {
  const std::vector<OccupancyShape> shapes{
      BoxShape(Vector3d::Constant(kSide_m), Translation({0, 0, 0.02}) * kPose)};
  Rehearsal rehearsal = Of(shapes);
  EXPECT_EQ(rehearsal.FailureOf(AcrossX({0.02, -0.01, 0.001}), jaw_, 0, 0.45),
            FailureReason::kNone);
}

TEST_F(RehearsalTest, OddShapesAndGraspsAreNotRehearsed) {
  OccupancyShape single = BoxShape(Vector3d::Constant(kSide_m), kPose);
  std::fill(single.occupancy.begin(), single.occupancy.end(), 0.0f);
  const std::vector<OccupancyShape> shapes{OccupancyShape(), single};
  Rehearsal rehearsal = Of(shapes);
  EXPECT_FALSE(rehearsal.FailuresOf(centered_, jaw_));
  Grasp nowhere = centered_;
  nowhere.X_WG.translation().x() = std::nan("");
  EXPECT_FALSE(rehearsal.FailuresOf(nowhere, jaw_));
  EXPECT_THAT(ErrorOf([&] { Of(shapes, {0, 0.45}); }), ::testing::HasSubstr("surface_levels"));
}

// A rehearsal keeps no state but the objects, which are made only once.
TEST_F(RehearsalTest, TheOrderOfCallsDoesNotMatter) {
  const std::vector<OccupancyShape> shapes{CubeBesidePossibleMatter(0.4f)};
  Rehearsal first = Of(shapes), second = Of(shapes);
  const Grasp aside = AcrossX({0.035, -0.01, 0.005});
  const auto a = first.FailuresOf(centered_, jaw_), b = first.FailuresOf(aside, jaw_);
  EXPECT_EQ(second.FailuresOf(aside, jaw_).value().hit, b.value().hit);
  EXPECT_EQ(second.FailuresOf(centered_, jaw_).value().hit, a.value().hit);
  EXPECT_NE(a->hit, b->hit);
  EXPECT_EQ(second.FailuresOf(aside, jaw_).value().lost, b->lost);
}

// The pose of the bin in the world moves everything.
TEST_F(RehearsalTest, IsTheSameInAMovedBin) {
  const Pose X_WB =
      MakePose(Eigen::AngleAxisd(0.7, Vector3d::UnitZ()).toRotationMatrix(), {0.4, -0.2, 0.3});
  OccupancyShape shape = CubeBesidePossibleMatter(0.4f);
  const std::vector<OccupancyShape> here{shape};
  shape.X_WV = X_WB * shape.X_WV;
  const std::vector<OccupancyShape> moved{shape};
  Rehearsal rehearsal = Of(here), in_bin(moved, X_WB.inverse(), assumed_, Bin().friction);
  Grasp grasp = centered_;
  grasp.X_WG = X_WB * grasp.X_WG;
  for (const double level : {0.3, 0.45}) {
    EXPECT_EQ(in_bin.FailureOf(grasp, jaw_, 0, level),
              rehearsal.FailureOf(centered_, jaw_, 0, level));
  }
}

}  // namespace
}  // namespace pickbed::tests
