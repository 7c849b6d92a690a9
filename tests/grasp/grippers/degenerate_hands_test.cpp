// Hands at the ends of their range: closed, without a load, and at bins that are just wide enough.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grasp/candidates/robustness.h"
#include "grasp/grippers/requirements.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/objects/contact.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

TEST(DegenerateHands, AClosedJawEnclosesNothing) {
  const ParallelJaw jaw = SmallJaw();
  EXPECT_EQ(jaw.TravelTime_s(0), 0);
  EXPECT_EQ(jaw.ApproachOpening_m(0), 2 * jaw.clearance_m);
  EXPECT_FALSE(jaw.ApproachOpening_m(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(jaw.ApproachOpening_m(std::numeric_limits<double>::infinity()));
  EXPECT_EQ(jaw.RegionBetween(0)->half_size.x(), 0);
  const std::vector<AxisAlignedBox> boxes = jaw.Boxes(0);
  const double gap_m = (boxes[1].center - boxes[0].center).x() - 2 * boxes[0].half_size.x();
  EXPECT_NEAR(gap_m, 0, 1e-12) << "the pads touch";
  const double open_gap_m =
      (jaw.Boxes(0.03)[1].center - jaw.Boxes(0.03)[0].center).x() - 2 * boxes[0].half_size.x();
  EXPECT_NEAR(open_gap_m, 0.03, 1e-12);
}

TEST(DegenerateHands, ACupHasOneShapeForAllWidths) {
  const SuctionCup cup;
  for (const double width_m : {0.0, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(cup.ApproachOpening_m(width_m), 0);
    EXPECT_TRUE(OpensFor(cup, width_m));
  }
  EXPECT_FALSE(cup.RegionBetween(0));
  EXPECT_EQ(cup.TravelTime_s(0), 0);
  for (const AxisAlignedBox& box : cup.Boxes(0)) EXPECT_TRUE((box.half_size.array() > 0).all());
}

TEST(DegenerateHands, OnlyAWidthWithinTheStrokeFits) {
  const ParallelJaw jaw = SmallJaw();
  EXPECT_TRUE(OpensFor(jaw, 0));
  EXPECT_TRUE(OpensFor(jaw, jaw.hand.stroke_m));
  const double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(OpensFor(jaw, kNaN));
  EXPECT_THAT(ErrorOf([&] { RequireOpensFor(jaw, kNaN); }), HasSubstr("opens at most 0.08 m"));
}

TEST(DegenerateHands, WithoutFrictionAJawCarriesNothing) {
  const ParallelJaw jaw = SmallJaw();
  EXPECT_TRUE(CanCarry(jaw, 0, 0.5));
  EXPECT_FALSE(CanCarry(jaw, 0, 0)) << "not even an object without weight";
  EXPECT_FALSE(CanCarry(jaw, 1e-9, 0));
  const SuctionCup cup;
  EXPECT_TRUE(CanCarry(cup, 0.1, 0)) << "a straight pull needs no friction";
}

TEST(DegenerateHands, ACupUnderItsLoadOnlyPulls) {
  const SuctionCup cup;
  ObjectModel object = *BoxObject({0.05, 0.05, 0.05}, 0.2);
  const Pose in_line = Translation({0, 0, 0.025});  // the center of mass is below the lip
  const double pull = cup.WeightShare(object, in_line, Vector3d::UnitZ());
  EXPECT_NEAR(pull, WrenchForce_n(object) / cup.cup.vacuum_n, 1e-9);
  EXPECT_GT(cup.WeightShare(object, Translation({0.02, 0, 0.025}), Vector3d::UnitZ()), pull);
  object.mass.mass_kg = 0;
  EXPECT_EQ(cup.WeightShare(object, in_line, Vector3d::UnitZ()), 0);
  EXPECT_EQ(cup.WeightShare(object, Translation({0.02, 0, 0.025}), Vector3d::UnitX()), 0);
}

TEST(DegenerateHands, ABinMustBeAsWideAsTheClosedHand) {
  const ParallelJaw jaw = SmallJaw();
  Bin bin;
  bin.inner_size_m.z() = 0.04;  // the palm stays above the rim
  const Vector3d fingers = jaw.hand.finger_size_m;
  const double across_m = 2 * fingers.x(), along_m = fingers.y();
  bin.inner_size_m.head<2>() = Eigen::Vector2d(across_m + 1e-9, along_m + 1e-9);
  EXPECT_EQ(ErrorOf([&] { RequireFitsBin(jaw, bin); }), "no error");
  bin.inner_size_m.head<2>() = Eigen::Vector2d(along_m - 1e-3, across_m);
  EXPECT_THAT(ErrorOf([&] { RequireFitsBin(jaw, bin); }), HasSubstr("is wider than the bin"));
  bin.inner_size_m.head<2>().setZero();
  EXPECT_THAT(ErrorOf([&] { RequireFitsBin(jaw, bin); }), HasSubstr("is wider than the bin"));
  bin.inner_size_m.setZero();
  EXPECT_EQ(ErrorOf([&] { RequireFitsBin(jaw, bin); }), "no error") << "a table has no walls";
}

}  // namespace
}  // namespace pickbed::tests
