#include "grasp/execute.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scenes/check.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

// A box of 40 x 50 x 50 mm; with the pads closing along x.
constexpr double kWidth_m = 0.040;
constexpr double kHeight_m = 0.050;

class Execute : public testing::Test {
 protected:
  static ObjectSet Boxes(double mass_kg, double friction = 0.5) {
    return {BoxPart({kWidth_m, 0.050, kHeight_m}, mass_kg, friction)};
  }

  static Grasp GraspAt(double x_m, double y_m, double width_m = kWidth_m) {
    Grasp grasp;
    grasp.X_WG = FromAbove({x_m, y_m, 0.015});
    grasp.width_m = width_m;
    return grasp;
  }

  ExecuteResult Run(const Scene& scene, const Grasp& grasp, const GraspTarget& target = 10) const {
    return ExecuteGrasp(scene, objects_, grasp, gripper_, target, options_);
  }

  // Names of the rules of success that were passed.
  static std::string Passed(const GraspOutcome& outcome) {
    std::string names;
    for (const SuccessRuleRow& row : SuccessRuleTable()) {
      if (outcome.verdicts[static_cast<int>(row.rule)]) names += std::string(row.name) + " ";
    }
    return names;
  }

  static Bin MeshBinFrom(const TriangleMesh& mesh) {
    Bin bin;
    bin.shape = std::make_shared<const BinShape>(MakeBinShape(mesh, "test bin"));
    bin.inner_size_m = bin.shape->inner_size_m;
    bin.wall_m = bin.shape->wall_m;
    return bin;
  }

  ExecuteOptions options_;

  GripperSpec gripper_ = SmallJaw();
  ObjectSet objects_ = Boxes(0.2);
};

TEST_F(Execute, GoodGraspOfALoneBoxSucceeds) {
  const ExecuteResult result = Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0, 0));
  const GraspOutcome& outcome = result.outcome;
  EXPECT_EQ(LossName(outcome.loss), LossName(Loss::kNone));
  EXPECT_TRUE(outcome.success);
  EXPECT_EQ(outcome.picked_instance, 10);
  EXPECT_EQ(outcome.parts_lifted, 1);
  EXPECT_NEAR(outcome.final_opening_m, kWidth_m, 0.002);
  EXPECT_LT(outcome.slip_m, 0.002);
  EXPECT_LT(outcome.turn_rad, 0.02);
  EXPECT_TRUE(result.after.objects.empty());
  EXPECT_EQ(Passed(outcome), "contact lifted held right_part single_part placed vgn_loose ");
  EXPECT_TRUE(outcome.set_down);
  EXPECT_LT(outcome.place_error_m, 0.002);
  EXPECT_LT(outcome.place_turn_rad, 0.02);
  // Above the rim of 15 cm, the tips as much as the part's diameter.
  const double lift_m = 0.15 + objects_[0]->diameter_m - 0.015;
  EXPECT_NEAR(outcome.lift_height_m, lift_m, 0.001);
  EXPECT_NEAR(outcome.retreat_opening, kWidth_m / gripper_.hand.stroke_m, 0.02);
}

// The wrist of a hand that points down feels the weight along its z, and about its origin the
// weight's torque: 9.81 * 0.2 N, 7 mm beside the hand's plane.
TEST_F(Execute, ContactWrenchIsTheWeightInTheHand) {
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0, 0.007)).outcome;
  ASSERT_TRUE(outcome.success);
  const double weight_n = 0.2 * 9.81;
  EXPECT_NEAR(outcome.contact_force_n.z(), weight_n, 0.01 * weight_n);
  EXPECT_LT(outcome.contact_force_n.head<2>().norm(), 0.01 * weight_n);
  EXPECT_NEAR(outcome.contact_torque_nm.head<2>().norm(), 0.007 * weight_n,
              0.05 * 0.007 * weight_n);
}

TEST_F(Execute, AFingerThatMeetsTheFloorIsACollision) {
  Grasp grasp = GraspAt(0.1, 0);
  grasp.X_WG.translation().z() = -0.01;
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kHeight_m), grasp).outcome;
  EXPECT_EQ(LossName(outcome.loss), LossName(Loss::kCollision));
  EXPECT_EQ(Passed(outcome), "");
}

TEST_F(Execute, APalmThatMeetsThePartIsACollision) {
  Grasp grasp = GraspAt(0, 0);
  gripper_.hand.finger_size_m.z() = 0.03;  // shorter than what stands between them
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kHeight_m), grasp).outcome;
  EXPECT_EQ(LossName(outcome.loss), LossName(Loss::kCollision));
}

// The palm reaches 2 cm from the middle of the hand, the fingers 1 cm: 1.5 cm from the wall the
// fingers pass, and only the palm is in the way.
TEST_F(Execute, APalmThatMeetsTheWallIsACollision) {
  const double wall_m = 0.5 * Bin{}.inner_size_m.y();
  const Scene scene = BoxesOnFloor({{0, wall_m - 0.026}}, kHeight_m);
  const GraspOutcome meets = Run(scene, GraspAt(0, wall_m - 0.015)).outcome;
  EXPECT_EQ(LossName(meets.loss), LossName(Loss::kCollision));
  const GraspOutcome beside = Run(scene, GraspAt(0, wall_m - 0.024)).outcome;
  EXPECT_EQ(LossName(beside.loss), LossName(Loss::kNone));
}

TEST_F(Execute, APalmThatMeetsTheWallOfAMeshBinIsACollision) {
  const Bin bin = MeshBinFrom(BinMesh(Bin{}));
  const double wall_m = 0.5 * bin.inner_size_m.y();
  Scene scene = BoxesOnFloor({{0, wall_m - 0.026}}, kHeight_m);
  scene.bin = bin;
  EXPECT_EQ(LossName(Run(scene, GraspAt(0, wall_m - 0.015)).outcome.loss),
            LossName(Loss::kCollision));
  EXPECT_EQ(LossName(Run(scene, GraspAt(0, wall_m - 0.024)).outcome.loss), LossName(Loss::kNone));
}

// From the side: the palm's lower edge goes 2 cm below the middle of the hand.
TEST_F(Execute, APalmThatMeetsTheFloorIsACollision) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kHeight_m);
  Eigen::Matrix3d R_WG;
  R_WG.col(0) = Vector3d::UnitY();
  R_WG.col(2) = Vector3d::UnitX();
  R_WG.col(1) = R_WG.col(2).cross(R_WG.col(0));
  Grasp grasp;
  grasp.width_m = 0.050;
  grasp.X_WG = MakePose(R_WG, {0, 0, 0.014});
  EXPECT_EQ(LossName(Run(scene, grasp).outcome.loss), LossName(Loss::kCollision));
  grasp.X_WG.translation().z() = 0.025;
  EXPECT_EQ(LossName(Run(scene, grasp).outcome.loss), LossName(Loss::kNone));
}

// Parts that are far enough to stand still are no thinner than those that move.
TEST_F(Execute, APalmThatMeetsAStaticPartIsACollision) {
  objects_.push_back(BoxPart({0.02, 0.02, 0.14}, 0.3));
  Scene scene = BoxesOnFloor({{0, 0}, {0.056, 0}}, kHeight_m);
  scene.objects[1].object = 1;
  scene.objects[1].X_WO.translation().z() = 0.0706;
  options_.world.near_m = -0.05;
  EXPECT_EQ(LossName(Run(scene, GraspAt(0, 0)).outcome.loss), LossName(Loss::kCollision));
  scene.objects[1].X_WO.translation().x() = 0.075;
  EXPECT_EQ(LossName(Run(scene, GraspAt(0, 0)).outcome.loss), LossName(Loss::kNone));
}

// A part believed 2 cm beside where it lies is set down as far from where it was to lie.
TEST_F(Execute, PlacingIsJudgedAgainstWhatWasBelieved) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kHeight_m);
  const Pose believed = Translation({0, 0.02, 0}) * scene.objects[0].X_WO;
  const GraspOutcome outcome = Run(scene, GraspAt(0, 0), {10, -1, believed}).outcome;
  EXPECT_TRUE(outcome.success);
  EXPECT_NEAR(outcome.place_error_m, 0.02, 0.002);
  EXPECT_EQ(Passed(outcome), "contact lifted held right_part single_part vgn_loose ");
}

TEST_F(Execute, TheRuleThatIsChosenDecides) {
  const Scene scene = BoxesOnFloor({{-0.1, 0}, {0.1, 0}}, kHeight_m);
  options_.rule = SuccessRule::kSinglePart;
  const GraspOutcome other = Run(scene, GraspAt(0.1, 0), 10).outcome;
  EXPECT_TRUE(other.success);
  EXPECT_EQ(LossName(other.loss), LossName(Loss::kNone));
  EXPECT_FALSE(other.is_target);
  options_.rule = SuccessRule::kPlaced;
  const Pose believed = Translation({0, 0.02, 0}) * scene.objects[0].X_WO;
  const GraspOutcome misplaced = Run(scene, GraspAt(-0.1, 0), {10, -1, believed}).outcome;
  EXPECT_FALSE(misplaced.success);
  EXPECT_EQ(LossName(misplaced.loss), LossName(Loss::kMisplaced));
}

TEST_F(Execute, WithoutAnInstanceTheKindDecides) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kHeight_m);
  EXPECT_TRUE(Run(scene, GraspAt(0, 0), {-1, 0}).outcome.success);
  const GraspOutcome other = Run(scene, GraspAt(0, 0), {-1, 1}).outcome;
  EXPECT_FALSE(other.success);
  EXPECT_EQ(LossName(other.loss), LossName(Loss::kWrongPart));
}

TEST_F(Execute, WithoutCarryItEndsWithTheShake) {
  options_.carry = false;
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0, 0)).outcome;
  EXPECT_FALSE(outcome.set_down);
  EXPECT_EQ(Passed(outcome), "contact lifted held right_part single_part vgn_loose ");
}

TEST_F(Execute, BesideTheBoxItClosesOnNothing) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0.10, 0));
  EXPECT_EQ(LossName(result.outcome.loss), LossName(Loss::kClosedOnNothing));
  EXPECT_FALSE(result.outcome.success);
  ASSERT_EQ(result.after.objects.size(), 1u);
  EXPECT_EQ(result.after.objects[0].instance, 10);
  const Vector3d moved =
      result.after.objects[0].X_WO.translation() - scene.objects[0].X_WO.translation();
  EXPECT_LT(moved.norm(), 0.001);
}

TEST_F(Execute, FingerOnTheBoxIsACollision) {
  const ExecuteResult result = Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0.5 * kWidth_m, 0));
  EXPECT_EQ(LossName(result.outcome.loss), LossName(Loss::kCollision));
  EXPECT_EQ(result.after.objects.size(), 1u);
}

// 2 * mu * F = 2 * 0.1 * 40 N holds 0.8 kg at rest.
TEST_F(Execute, WeightTwiceTheFrictionLimitIsLost) {
  objects_ = Boxes(1.6, 0.1);
  const ExecuteResult result = Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0, 0));
  EXPECT_TRUE(result.outcome.loss == Loss::kSlipped || result.outcome.loss == Loss::kDropped)
      << LossName(result.outcome.loss);
  ASSERT_EQ(result.after.objects.size(), 1u);
  EXPECT_NEAR(result.after.objects[0].X_WO.translation().z(), 0.5 * kHeight_m, 0.002);
}

TEST_F(Execute, WeightHalfTheFrictionLimitIsHeld) {
  objects_ = Boxes(0.4, 0.1);
  EXPECT_TRUE(Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0, 0)).outcome.success);
}

// A part that lay higher than half of the lift comes down again on its way to the table.
TEST_F(Execute, APartFromHighUpIsStillInTheHandOverTheTable) {
  Scene scene = BoxesOnFloor({{0, 0}, {0, 0}, {0, 0}, {0, 0}}, kHeight_m);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    scene.objects[i].X_WO.translation().z() += static_cast<double>(i) * kHeight_m;
  }
  Grasp grasp = GraspAt(0, 0);
  const double top_m = static_cast<double>(scene.objects.size() - 1) * kHeight_m;
  ASSERT_GT(top_m, 0.5 * options_.lift_m);
  grasp.X_WG.translation().z() += top_m;
  const ExecuteResult result = Run(scene, grasp, scene.objects.back().instance);
  EXPECT_EQ(LossName(result.outcome.loss), LossName(Loss::kNone));
  EXPECT_TRUE(result.outcome.set_down);
}

// From the top of a pile in a deep bin the straight way to the table would go through the wall.
TEST_F(Execute, ItIsLiftedOverAHighRim) {
  Bin box;
  box.inner_size_m = {0.30, 0.24, 0.45};
  for (const Bin& bin : {box, MeshBinFrom(BinMesh(box))}) {
    Scene scene = BoxesOnFloor({{0, 0}, {0, 0}, {0, 0}, {0, 0}}, kHeight_m);
    scene.bin = bin;
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      scene.objects[i].X_WO.translation().z() += static_cast<double>(i) * kHeight_m;
    }
    Grasp grasp = GraspAt(0, 0);
    grasp.X_WG.translation().z() += 3 * kHeight_m;
    const GraspOutcome outcome = Run(scene, grasp, 13).outcome;
    EXPECT_EQ(LossName(outcome.loss), LossName(Loss::kNone));
    EXPECT_TRUE(outcome.set_down);
    EXPECT_LT(outcome.place_error_m, 0.002);
  }
}

TEST_F(Execute, TwoBoxesBetweenTheFingersAreTwo) {
  objects_ = {BoxPart({0.030, 0.050, kHeight_m}, 0.1)};
  const Scene scene = BoxesOnFloor({{-0.0153, 0}, {0.0153, 0}}, kHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0, 0, 0.0612));
  EXPECT_EQ(LossName(result.outcome.loss), LossName(Loss::kTookTwo));
  EXPECT_EQ(result.outcome.parts_lifted, 2);
  EXPECT_TRUE(result.after.objects.empty());
}

TEST_F(Execute, OtherPartThanMeantIsTheWrongPart) {
  const Scene scene = BoxesOnFloor({{-0.1, 0}, {0.1, 0}}, kHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0.1, 0), 10);
  EXPECT_EQ(LossName(result.outcome.loss), LossName(Loss::kWrongPart));
  EXPECT_EQ(result.outcome.picked_instance, 11);
  ASSERT_EQ(result.after.objects.size(), 1u);
  EXPECT_EQ(result.after.objects[0].instance, 10);
}

TEST_F(Execute, WithoutATargetAnySinglePartWillDo) {
  const Scene scene = BoxesOnFloor({{-0.1, 0}, {0.1, 0}}, kHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0.1, 0), -1);
  EXPECT_TRUE(result.outcome.success);
  EXPECT_EQ(result.outcome.picked_instance, 11);
}

TEST_F(Execute, PartOnTopIsThrownDownAndCounted) {
  Scene scene = BoxesOnFloor({{0, 0}, {0.0, 0}}, kHeight_m);
  // Rests on the target beside the palm's way, balanced on its edge side.
  objects_.push_back(BoxPart({0.010, 0.040, 0.010}, 0.02));
  scene.objects[1].object = 1;
  scene.objects[1].X_WO = Translation({0, 0.035, kHeight_m + 0.0012 + 0.005});
  scene.objects[1].X_WO.translation().y() = 0.027;
  gripper_.hand.finger_size_m.z() = 0.08;
  const ExecuteResult result = Run(scene, GraspAt(0, 0));
  EXPECT_EQ(result.outcome.picked_instance, 10);
  EXPECT_EQ(result.outcome.disturbed + result.outcome.parts_lifted, 2);
}

TEST_F(Execute, EmptyBinIsClosedOnNothing) {
  const ExecuteResult result = Run(Scene{}, GraspAt(0, 0), -1);
  EXPECT_EQ(LossName(result.outcome.loss), LossName(Loss::kClosedOnNothing));
}

TEST_F(Execute, PartWithoutConvexPiecesIsACallersFault) {
  auto bare = std::make_shared<ObjectModel>(*objects_[0]);
  bare->convex_parts_O.clear();
  objects_ = {bare};
  EXPECT_THROW(Run(BoxesOnFloor({{0, 0}}, kHeight_m), GraspAt(0, 0)), std::logic_error);
}

TEST_F(Execute, EverySettingHasARange) {
  ExecuteOptions options;
  const auto visit = [&](SettingsVisitor& v) { options.Visit(v); };
  ApplySetting("world.near_m=0.05", visit);
  ApplySetting("place.touch_n=3", visit);
  ApplySetting("rules.loose_opening=0.2", visit);
  EXPECT_EQ(options.world.near_m, 0.05);
  EXPECT_EQ(options.place.touch_n, 3);
  EXPECT_EQ(options.rules.loose_opening, 0.2);
  EXPECT_THROW(ApplySetting("shake_hz=0", visit), InputError);
  EXPECT_THROW(ApplySetting("place.release_mps=-1", visit), InputError);
  // What is written reads back: every default lies in its range.
  EXPECT_NO_THROW(ReadSettingsText(WriteSettings(visit), "defaults", visit));
}

TEST_F(Execute, SameInputsSameBytes) {
  const Scene scene = BoxesOnFloor({{0, 0}, {0.045, 0.01}, {0.0, 0.06}}, kHeight_m);
  const ExecuteResult a = Run(scene, GraspAt(0.001, 0.002));
  const ExecuteResult b = Run(scene, GraspAt(0.001, 0.002));
  EXPECT_EQ(a.outcome.loss, b.outcome.loss);
  EXPECT_EQ(a.outcome.slip_m, b.outcome.slip_m);
  EXPECT_EQ(a.outcome.final_opening_m, b.outcome.final_opening_m);
  ASSERT_EQ(a.after.objects.size(), b.after.objects.size());
  for (size_t i = 0; i < a.after.objects.size(); ++i) {
    EXPECT_EQ(a.after.objects[i].X_WO.matrix(), b.after.objects[i].X_WO.matrix());
  }
}

}  // namespace
}  // namespace pickbed
