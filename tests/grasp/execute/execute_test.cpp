#include "grasp/execute/execute.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scenes/base/error.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A box of 40 x 50 x 50 mm. The pads close along x.
constexpr double kWidth_m = 0.040;
constexpr double kBoxHeight_m = 0.050;

class Execute : public testing::Test {
 protected:
  static ObjectSet Boxes(double mass_kg, double friction = 0.5) {
    return {BoxObject({kWidth_m, 0.050, kBoxHeight_m}, mass_kg, friction)};
  }

  static Grasp GraspAt(double x_m, double y_m, double width_m = kWidth_m) {
    Grasp grasp;
    grasp.X_WG = FromAbove({x_m, y_m, 0.015});
    grasp.width_m = width_m;
    return grasp;
  }

  ExecuteResult Run(const Scene& scene, const Grasp& grasp,
                    const GraspTarget& target = InstanceId{10}) const {
    return ExecuteGrasp(scene, objects_, grasp, gripper_, target, options_);
  }

  // Returns the names of the passed success rules.
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

  ParallelJaw gripper_ = SmallJaw();
  ObjectSet objects_ = Boxes(0.2);
};

TEST_F(Execute, CenteredGraspOfASingleBoxSucceeds) {
  const ExecuteResult result = Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0));
  const GraspOutcome& outcome = result.outcome;
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kNone));
  EXPECT_TRUE(outcome.success);
  EXPECT_EQ(outcome.picked_instance, 10);
  EXPECT_EQ(outcome.instances_lifted, 1);
  EXPECT_NEAR(outcome.final_opening_m, kWidth_m, 0.002);
  EXPECT_LT(outcome.slip_m, 0.002);
  EXPECT_LT(outcome.in_hand_rotation_error_rad, 0.02);
  EXPECT_TRUE(result.after.objects.empty());
  EXPECT_EQ(Passed(outcome),
            "contact lifted held right_instance single_instance placed vgn_loose ");
  EXPECT_TRUE(outcome.place_executed);
  EXPECT_LT(outcome.place_error_m, 0.002);
  EXPECT_LT(outcome.place_rotation_error_rad, 0.02);
  // The tips rise above the rim of 15 cm by the diameter of the object.
  const double lift_m = 0.15 + objects_[0]->diameter_m - 0.015;
  EXPECT_NEAR(outcome.lift_height_m, lift_m, 0.001);
  EXPECT_NEAR(outcome.retreat_opening, kWidth_m / gripper_.hand.stroke_m, 0.02);
}

// The hand points down: its wrist carries the weight along z, and the torque of the weight about
// its origin: 0.2 * 9.81 N, 7 mm beside the plane of the hand.
TEST_F(Execute, ContactWrenchIsTheWeightOfTheBox) {
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0.007)).outcome;
  ASSERT_TRUE(outcome.success);
  const double weight_n = 0.2 * 9.81;
  EXPECT_NEAR(outcome.contact_force_n.z(), weight_n, 0.01 * weight_n);
  EXPECT_LT(outcome.contact_force_n.head<2>().norm(), 0.01 * weight_n);
  EXPECT_NEAR(outcome.contact_torque_nm.head<2>().norm(), 0.007 * weight_n,
              0.05 * 0.007 * weight_n);
}

TEST_F(Execute, FingerAgainstTheFloorIsACollision) {
  Grasp grasp = GraspAt(0.1, 0);
  grasp.X_WG.translation().z() = -0.01;
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), grasp).outcome;
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kCollision));
  EXPECT_EQ(Passed(outcome), "");
}

TEST_F(Execute, PalmAgainstTheObjectIsACollision) {
  Grasp grasp = GraspAt(0, 0);
  gripper_.hand.finger_size_m.z() = 0.03;  // shorter than the box between them
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), grasp).outcome;
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kCollision));
}

// The palm extends 2 cm from the center of the hand, the fingers 1 cm. At 1.5 cm from the wall the
// fingers are free, and only the palm collides.
TEST_F(Execute, PalmAgainstTheWallIsACollision) {
  const double wall_m = 0.5 * Bin{}.inner_size_m.y();
  const Scene scene = BoxesOnFloor({{0, wall_m - 0.026}}, kBoxHeight_m);
  const GraspOutcome colliding = Run(scene, GraspAt(0, wall_m - 0.015)).outcome;
  EXPECT_EQ(FailureName(colliding.failure), FailureName(FailureReason::kCollision));
  const GraspOutcome free = Run(scene, GraspAt(0, wall_m - 0.024)).outcome;
  EXPECT_EQ(FailureName(free.failure), FailureName(FailureReason::kNone));
}

TEST_F(Execute, PalmAgainstTheWallOfAMeshBinIsACollision) {
  const Bin bin = MeshBinFrom(BinMesh(Bin{}));
  const double wall_m = 0.5 * bin.inner_size_m.y();
  Scene scene = BoxesOnFloor({{0, wall_m - 0.026}}, kBoxHeight_m);
  scene.bin = bin;
  EXPECT_EQ(FailureName(Run(scene, GraspAt(0, wall_m - 0.015)).outcome.failure),
            FailureName(FailureReason::kCollision));
  EXPECT_EQ(FailureName(Run(scene, GraspAt(0, wall_m - 0.024)).outcome.failure),
            FailureName(FailureReason::kNone));
}

// The hand approaches from the side. The lower edge of the palm is 2 cm below the center of the
// hand.
TEST_F(Execute, PalmAgainstTheFloorIsACollision) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kBoxHeight_m);
  Eigen::Matrix3d R_WG;
  R_WG.col(0) = Vector3d::UnitY();
  R_WG.col(2) = Vector3d::UnitX();
  R_WG.col(1) = R_WG.col(2).cross(R_WG.col(0));
  Grasp grasp;
  grasp.width_m = 0.050;
  grasp.X_WG = MakePose(R_WG, {0, 0, 0.014});
  EXPECT_EQ(FailureName(Run(scene, grasp).outcome.failure), FailureName(FailureReason::kCollision));
  grasp.X_WG.translation().z() = 0.025;
  EXPECT_EQ(FailureName(Run(scene, grasp).outcome.failure), FailureName(FailureReason::kNone));
}

// Distant instances are static bodies. They have the same collision geometry as moving ones.
TEST_F(Execute, PalmAgainstAStaticInstanceIsACollision) {
  objects_.push_back(BoxObject({0.02, 0.02, 0.14}, 0.3));
  Scene scene = BoxesOnFloor({{0, 0}, {0.056, 0}}, kBoxHeight_m);
  scene.objects[1].object = ObjectId{1};
  scene.objects[1].X_WO.translation().z() = 0.0706;
  options_.world.near_m = -0.05;
  EXPECT_EQ(FailureName(Run(scene, GraspAt(0, 0)).outcome.failure),
            FailureName(FailureReason::kCollision));
  scene.objects[1].X_WO.translation().x() = 0.075;
  EXPECT_EQ(FailureName(Run(scene, GraspAt(0, 0)).outcome.failure),
            FailureName(FailureReason::kNone));
}

// If the estimated pose has an error of 2 cm, the set-down has the same error.
TEST_F(Execute, PlacementErrorIncludesTheEstimationError) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kBoxHeight_m);
  const Pose estimated = Translation({0, 0.02, 0}) * scene.objects[0].X_WO;
  const GraspOutcome outcome =
      Run(scene, GraspAt(0, 0), {InstanceId{10}, kAnyObject, estimated}).outcome;
  EXPECT_TRUE(outcome.success);
  EXPECT_NEAR(outcome.place_error_m, 0.02, 0.002);
  EXPECT_EQ(Passed(outcome), "contact lifted held right_instance single_instance vgn_loose ");
}

// The listener is called after every step and does not change the result.
TEST_F(Execute, ListenerFollowsTheMotion) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kBoxHeight_m);
  std::vector<double> times_s, heights_m;
  bool has_table = false;
  const MotionListener listener = [&](const MotionState& state) {
    times_s.push_back(state.time_s);
    heights_m.push_back(state.world.PoseOf(0).translation().z());
    has_table = has_table || state.table_W != nullptr;
  };
  const ExecuteResult heard =
      ExecuteGrasp(scene, objects_, GraspAt(0, 0), gripper_, InstanceId{10}, options_, listener);
  EXPECT_EQ(heard.outcome.lift_height_m, Run(scene, GraspAt(0, 0)).outcome.lift_height_m);
  ASSERT_GT(times_s.size(), 1000u);
  for (size_t i = 1; i < times_s.size(); ++i) {
    ASSERT_NEAR(times_s[i] - times_s[i - 1], 1 / options_.physics.rate_hz, 1e-9);
  }
  EXPECT_GT(*std::max_element(heights_m.begin(), heights_m.end()),
            heights_m.front() + 0.9 * options_.lift_m);
  EXPECT_TRUE(has_table);
}

TEST_F(Execute, SelectedRuleDecidesSuccess) {
  const Scene scene = BoxesOnFloor({{-0.1, 0}, {0.1, 0}}, kBoxHeight_m);
  options_.rule = SuccessRule::kSingleInstance;
  const GraspOutcome other = Run(scene, GraspAt(0.1, 0), InstanceId{10}).outcome;
  EXPECT_TRUE(other.success);
  EXPECT_EQ(FailureName(other.failure), FailureName(FailureReason::kNone));
  EXPECT_FALSE(other.is_target);
  options_.rule = SuccessRule::kPlaced;
  const Pose estimated = Translation({0, 0.02, 0}) * scene.objects[0].X_WO;
  const GraspOutcome misplaced =
      Run(scene, GraspAt(-0.1, 0), {InstanceId{10}, kAnyObject, estimated}).outcome;
  EXPECT_FALSE(misplaced.success);
  EXPECT_EQ(FailureName(misplaced.failure), FailureName(FailureReason::kMisplaced));
}

TEST_F(Execute, WithoutTargetInstanceTheObjectDecides) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kBoxHeight_m);
  EXPECT_TRUE(Run(scene, GraspAt(0, 0), {kNoInstance, ObjectId{0}}).outcome.success);
  const GraspOutcome other = Run(scene, GraspAt(0, 0), {kNoInstance, ObjectId{1}}).outcome;
  EXPECT_FALSE(other.success);
  EXPECT_EQ(FailureName(other.failure), FailureName(FailureReason::kWrongObject));
}

// The hand turns a box that is not on its only resting side. The cell knows
// no resting side of an unknown box.
TEST_F(Execute, UnknownTargetIsPlacedAsItWasPicked) {
  auto turned = std::make_shared<ObjectModel>(*objects_[0]);
  turned->resting_O = {{Vector3d::UnitY(), 1}};
  objects_ = {turned};
  const auto max_tilt_of = [&](const GraspTarget& target) {
    double max_tilt_rad = 0;
    ExecuteGrasp(BoxesOnFloor({{0, 0}}, kBoxHeight_m), objects_, GraspAt(0, 0), gripper_, target,
                 options_, [&](const MotionState& state) {
                   const double down = -state.hand.X_WG().linear()(2, 2);
                   max_tilt_rad = std::max(max_tilt_rad, std::acos(std::min(1.0, down)));
                 });
    return max_tilt_rad;
  };
  EXPECT_GT(max_tilt_of(InstanceId{10}), 0.5);
  EXPECT_LT(max_tilt_of({}), 0.01);
  EXPECT_TRUE(Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0), {}).outcome.place_executed);
}

TEST_F(Execute, WithoutCarryTheAttemptEndsAfterTheShake) {
  options_.carry = false;
  const GraspOutcome outcome = Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0)).outcome;
  EXPECT_FALSE(outcome.place_executed);
  EXPECT_EQ(Passed(outcome), "contact lifted held right_instance single_instance vgn_loose ");
}

TEST_F(Execute, GraspBesideTheBoxClosesEmpty) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kBoxHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0.10, 0));
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kClosedOnNothing));
  EXPECT_FALSE(result.outcome.success);
  ASSERT_EQ(result.after.objects.size(), 1u);
  EXPECT_EQ(result.after.objects[0].instance, 10);
  const Vector3d moved =
      result.after.objects[0].X_WO.translation() - scene.objects[0].X_WO.translation();
  EXPECT_LT(moved.norm(), 0.001);
}

TEST_F(Execute, FingerOnTheBoxIsACollision) {
  const ExecuteResult result =
      Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0.5 * kWidth_m, 0));
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kCollision));
  EXPECT_EQ(result.after.objects.size(), 1u);
}

// 2 * mu * F = 2 * 0.1 * 40 N holds 0.8 kg at rest.
TEST_F(Execute, TwiceTheFrictionLimitIsLost) {
  objects_ = Boxes(1.6, 0.1);
  const ExecuteResult result = Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0));
  EXPECT_TRUE(result.outcome.failure == FailureReason::kSlipped ||
              result.outcome.failure == FailureReason::kDropped)
      << FailureName(result.outcome.failure);
  ASSERT_EQ(result.after.objects.size(), 1u);
  EXPECT_NEAR(result.after.objects[0].X_WO.translation().z(), 0.5 * kBoxHeight_m, 0.002);
}

TEST_F(Execute, HalfTheFrictionLimitIsHeld) {
  objects_ = Boxes(0.4, 0.1);
  EXPECT_TRUE(Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0)).outcome.success);
}

// An instance picked from above half of the lift height moves down on its way to the table.
TEST_F(Execute, HighInstanceIsStillHeldAboveTheTable) {
  Scene scene = BoxesOnFloor({{0, 0}, {0, 0}, {0, 0}, {0, 0}}, kBoxHeight_m);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    scene.objects[i].X_WO.translation().z() += static_cast<double>(i) * kBoxHeight_m;
  }
  Grasp grasp = GraspAt(0, 0);
  const double top_m = static_cast<double>(scene.objects.size() - 1) * kBoxHeight_m;
  ASSERT_GT(top_m, 0.5 * options_.lift_m);
  grasp.X_WG.translation().z() += top_m;
  const ExecuteResult result = Run(scene, grasp, scene.objects.back().instance);
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kNone));
  EXPECT_TRUE(result.outcome.place_executed);
}

// The straight path from the top of a stack in a deep bin to the table would pass through the wall.
TEST_F(Execute, InstanceIsLiftedAboveAHighRim) {
  Bin box;
  box.inner_size_m = {0.30, 0.24, 0.45};
  for (const Bin& bin : {box, MeshBinFrom(BinMesh(box))}) {
    Scene scene = BoxesOnFloor({{0, 0}, {0, 0}, {0, 0}, {0, 0}}, kBoxHeight_m);
    scene.bin = bin;
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      scene.objects[i].X_WO.translation().z() += static_cast<double>(i) * kBoxHeight_m;
    }
    Grasp grasp = GraspAt(0, 0);
    grasp.X_WG.translation().z() += 3 * kBoxHeight_m;
    const GraspOutcome outcome = Run(scene, grasp, InstanceId{13}).outcome;
    EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kNone));
    EXPECT_TRUE(outcome.place_executed);
    EXPECT_LT(outcome.place_error_m, 0.002);
  }
}

TEST_F(Execute, TwoBoxesBetweenTheFingersAreADoublePick) {
  objects_ = {BoxObject({0.030, 0.050, kBoxHeight_m}, 0.1)};
  const Scene scene = BoxesOnFloor({{-0.0153, 0}, {0.0153, 0}}, kBoxHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0, 0, 0.0612));
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kDoublePick));
  EXPECT_EQ(result.outcome.instances_lifted, 2);
  EXPECT_EQ(result.outcome.instances_entangled, 0);
  EXPECT_TRUE(result.after.objects.empty());
}

// A plate held at its stem carries a cube between its stem and its upright edge.
TEST_F(Execute, InstanceCarriedWithoutContactToTheHandIsEntangled) {
  objects_ = {ObjectOfBoxes("tray",
                            {{{0, 0, 0.05}, {0.02, 0.02, 0.05}},
                             {{0, 0, 0.005}, {0.02, 0.09, 0.005}},
                             {{0, 0.085, 0.025}, {0.02, 0.005, 0.025}}},
                            0.2),
              BoxObject({0.03, 0.03, 0.03}, 0.02)};
  Scene scene;
  scene.objects = {{InstanceId{10}, ObjectId{0}, Translation({0, 0, 0.0006})},
                   {InstanceId{11}, ObjectId{1}, Translation({0, 0.055, 0.0262})}};
  Grasp grasp = GraspAt(0, 0);
  grasp.X_WG.translation().z() = 0.07;
  const ExecuteResult result = Run(scene, grasp);
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kEntangled));
  EXPECT_EQ(result.outcome.picked_instance, 10);
  EXPECT_EQ(result.outcome.instances_lifted, 2);
  EXPECT_EQ(result.outcome.instances_entangled, 1);
  EXPECT_TRUE(result.after.objects.empty()) << "both left the bin";
  EXPECT_EQ(Passed(result.outcome), "contact lifted held vgn_loose ");

  scene.objects.pop_back();
  EXPECT_TRUE(Run(scene, grasp).outcome.success) << "without the cube the grasp holds";
}

TEST_F(Execute, OtherInstanceThanTheTargetIsAWrongPick) {
  const Scene scene = BoxesOnFloor({{-0.1, 0}, {0.1, 0}}, kBoxHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0.1, 0), InstanceId{10});
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kWrongObject));
  EXPECT_EQ(result.outcome.picked_instance, 11);
  ASSERT_EQ(result.after.objects.size(), 1u);
  EXPECT_EQ(result.after.objects[0].instance, 10);
}

TEST_F(Execute, WithoutTargetAnySingleInstanceSucceeds) {
  const Scene scene = BoxesOnFloor({{-0.1, 0}, {0.1, 0}}, kBoxHeight_m);
  const ExecuteResult result = Run(scene, GraspAt(0.1, 0), kNoInstance);
  EXPECT_TRUE(result.outcome.success);
  EXPECT_EQ(result.outcome.picked_instance, 11);
}

TEST_F(Execute, InstanceOnTopIsDisplacedAndCounted) {
  Scene scene = BoxesOnFloor({{0, 0}, {0.0, 0}}, kBoxHeight_m);
  // It rests on the target beside the path of the palm.
  objects_.push_back(BoxObject({0.010, 0.040, 0.010}, 0.02));
  scene.objects[1].object = ObjectId{1};
  scene.objects[1].X_WO = Translation({0, 0.035, kBoxHeight_m + 0.0012 + 0.005});
  scene.objects[1].X_WO.translation().y() = 0.027;
  gripper_.hand.finger_size_m.z() = 0.08;
  const ExecuteResult result = Run(scene, GraspAt(0, 0));
  EXPECT_EQ(result.outcome.picked_instance, 10);
  EXPECT_EQ(result.outcome.neighbors_displaced + result.outcome.instances_lifted, 2);
}

// No robot reaches a pose under the floor, so it is no grasp in free air.
TEST_F(Execute, AGraspUnderTheFloorCollides) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kBoxHeight_m);
  for (const double depth_m : {0.02, 0.1, 0.5}) {
    for (const double x_m : {0.0, 1.0}) {  // in the bin and beside it
      Grasp grasp = GraspAt(x_m, 0);
      grasp.X_WG.translation().z() = -depth_m;
      const ExecuteResult result = Run(scene, grasp);
      EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kCollision))
          << depth_m << " m under the floor at x = " << x_m;
      EXPECT_EQ(result.after.objects.size(), 1u);
    }
  }
}

TEST_F(Execute, HandClosesEmptyInAnEmptyBin) {
  const ExecuteResult result = Run(Scene{}, GraspAt(0, 0), kNoInstance);
  EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kClosedOnNothing));
}

TEST_F(Execute, ObjectWithoutPiecesIsALogicError) {
  auto bare = std::make_shared<ObjectModel>(*objects_[0]);
  bare->convex_pieces_O.clear();
  objects_ = {bare};
  EXPECT_THROW(Run(BoxesOnFloor({{0, 0}}, kBoxHeight_m), GraspAt(0, 0)), std::logic_error);
}

TEST_F(Execute, DefaultsAreInTheRangesOfTheSettings) {
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
  // Written settings read back, so every default is in its range.
  EXPECT_NO_THROW(ReadSettingsText(WriteSettings(visit), "defaults", visit));
}

TEST_F(Execute, SameInputsGiveSameBytes) {
  const Scene scene = BoxesOnFloor({{0, 0}, {0.045, 0.01}, {0.0, 0.06}}, kBoxHeight_m);
  const ExecuteResult a = Run(scene, GraspAt(0.001, 0.002));
  const ExecuteResult b = Run(scene, GraspAt(0.001, 0.002));
  EXPECT_EQ(a.outcome.failure, b.outcome.failure);
  EXPECT_EQ(a.outcome.slip_m, b.outcome.slip_m);
  EXPECT_EQ(a.outcome.final_opening_m, b.outcome.final_opening_m);
  ASSERT_EQ(a.after.objects.size(), b.after.objects.size());
  for (size_t i = 0; i < a.after.objects.size(); ++i) {
    EXPECT_EQ(a.after.objects[i].X_WO.matrix(), b.after.objects[i].X_WO.matrix());
  }
}

}  // namespace
}  // namespace pickbed::tests
