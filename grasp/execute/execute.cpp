#include "grasp/execute/execute.h"

#include <algorithm>
#include <cmath>

#include "grasp/execute/pick_up.h"
#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

// Picks an instance up, carries it to the table and sets it down.
class Attempt {
 public:
  Attempt(const Scene& scene, const ObjectSet& objects, const Grasp& grasp, const Gripper& gripper,
          const GraspTarget& target, const ExecuteOptions& options, const MotionListener& on_step)
      : bin_(scene.bin),
        gripper_(gripper),
        target_(target),
        options_(options),
        pick_(scene, objects, grasp, gripper, target, options, on_step) {}

  ExecuteResult Run() {
    ExecuteResult result;
    GraspOutcome& outcome = result.outcome;
    outcome.failure = Try(outcome);
    if (outcome.failure != FailureReason::kPhysicsFailed && carried_.empty()) Withdraw();
    if (world().physics().BlewUp()) outcome.failure = FailureReason::kPhysicsFailed;
    Judge(outcome);
    const bool failed = outcome.failure == FailureReason::kPhysicsFailed;
    result.after = failed ? world().snapshot() : world().Remaining(carried_);
    if (!failed) {
      outcome.neighbors_displaced =
          world().Displaced(options_.displaced_m, carried_, target_.instance);
    }
    return result;
  }

 private:
  FailureReason Try(GraspOutcome& outcome) {
    const FailureReason lost = pick_.Run(outcome);
    if (lost != FailureReason::kNone) return lost;
    outcome.final_opening_m = hand().opening_m();
    pick_.RecordGrip(outcome);
    const int picked = pick_.PickedOf(pick_.Held());
    if (options_.carry && picked >= 0) Carry(picked);
    if (world().physics().BlewUp()) return FailureReason::kPhysicsFailed;
    carried_ = pick_.Held();
    const FailureReason failure = JudgeHeld(outcome);
    if (options_.carry && failure == FailureReason::kNone) SetDown(carried_.front(), outcome);
    return failure;
  }

  // Model with which the placement is planned.
  const ObjectModel& AssumedModel(int picked) const {
    return target_.model != nullptr ? *target_.model : world().ModelOf(picked);
  }

  // Model that rests only in its present orientation. A cell that does not know an object cannot
  // know how it rests, so the hand does not turn.
  static ObjectModel AsPicked(const ObjectModel& model, const Pose& X_WO) {
    ObjectModel picked = model;
    picked.resting_O = {{X_WO.linear().row(2), 1}};
    picked.symmetries_O = {};
    return picked;
  }

  // Moves up until hand and object clear the rim, then to above the table. The pose in the
  // hand and the size are as the cell assumes.
  void Carry(int picked) {
    const ObjectModel& model = AssumedModel(picked);
    const Pose X_WO = target_.X_WO.value_or(world().Posed(picked).X_WO);
    const Pose X_WG = target_.planned_X_WG.value_or(pick_.X_WG());
    const std::vector<AxisAlignedBox>& boxes_G = pick_.boxes_G();
    place_ = target_.IsUnknown()
                 ? PlanPlace(bin_, AsPicked(model, X_WO), X_WO, X_WG, boxes_G, options_.place)
                 : PlanPlace(bin_, model, X_WO, X_WG, boxes_G, options_.place);
    world().physics().AddStaticBox(Translation(place_.table_W.center), place_.table_W.half_size,
                                   bin_.friction);
    pick_.ShowTable(place_.table_W);
    Pose up = pick_.Lifted(), over = place_.X_WG;
    const double height_m = std::max(
        up.translation().z(),
        CarryHeight_m(bin_, model, X_WG.inverse() * X_WO, up, over, boxes_G, options_.place));
    up.translation().z() = over.translation().z() = height_m;
    pick_.Move(up, options_.carry_mps);
    pick_.Move(over, options_.carry_mps);
  }

  void SetDown(int picked, GraspOutcome& outcome) {
    pick_.Move(Translation({0, 0, options_.place.slow_m}) * place_.X_WG, options_.place.lower_mps);
    LowerUntilTouch();
    LetGo(options_.place.release_mps);
    Withdraw();
    const PlaceError error =
        PlaceErrorOf(AssumedModel(picked), place_.X_WO, world().physics().X_WO(picked),
                     world().ModelOf(picked).mass.com_O);
    outcome.place_executed = true;
    outcome.place_error_m = error.distance_m;
    outcome.place_rotation_error_rad = error.rotation_error_rad;
  }

  // Descends until the table takes some of the load, or to the end of the path.
  void LowerUntilTouch() {
    const PlaceOptions& place = options_.place;
    const double share = std::min(1.0, world().physics().step_s() / options_.stop_window_s);
    const Pose from = hand().X_WG();
    double felt_n = UpwardLoad_n();
    for (int i = 0; i < world().Steps(place.steady_s); ++i) {
      pick_.Advance(from);
      felt_n += share * (UpwardLoad_n() - felt_n);
    }
    const double weight_n = felt_n;
    const double way_m = place.slow_m + place_.overtravel_m;
    const int steps = world().Steps(way_m / place.slow_mps);
    for (int i = 1; i <= steps; ++i) {
      pick_.Advance(Translation({0, 0, -way_m * i / steps}) * from);
      felt_n += share * (UpwardLoad_n() - felt_n);
      if (felt_n - weight_n > place.touch_n) return;
    }
  }

  double UpwardLoad_n() { return (hand().X_WG().linear() * hand().Load().force_n).z(); }

  FailureReason JudgeHeld(GraspOutcome& outcome) const {
    outcome.instances_lifted = static_cast<int>(carried_.size());
    if (carried_.empty()) return FailureReason::kDropped;
    const int picked = pick_.PickedOf(carried_);
    outcome.picked_instance = world().Posed(picked).instance;
    outcome.is_target = pick_.IsTarget(picked);
    const auto entangled = std::count_if(carried_.begin(), carried_.end(), [&](int position) {
      return position != picked && !pick_.IsGripped(position);
    });
    outcome.instances_entangled = static_cast<int>(entangled);
    if (carried_.size() > 1) {
      const bool all = outcome.instances_entangled + 1 == outcome.instances_lifted;
      return all ? FailureReason::kEntangled : FailureReason::kDoublePick;
    }
    return outcome.is_target ? FailureReason::kNone : FailureReason::kWrongObject;
  }

  // Opens to the opening of the approach, slowly, so that a finger does not drag the instance
  // along.
  void LetGo(double finger_mps) {
    const Pose X_WG = hand().X_WG();
    const double from_m = hand().opening_m();
    const double way_m = std::max(0.0, pick_.opening_m() - from_m);
    const int steps = world().Steps(0.5 * way_m / finger_mps);
    for (int i = 1; i <= steps; ++i) {
      hand().HoldOpening(from_m + way_m * i / steps);
      pick_.Advance(X_WG);
    }
    hand().HoldOpening(pick_.opening_m());
    const int last = world().Steps(gripper_.TravelTime_s(pick_.opening_m() - hand().opening_m()));
    for (int i = 0; i < last; ++i) pick_.Advance(X_WG);
  }

  // Opens, retreats along the approach and lets the instances come to rest.
  void Withdraw() {
    hand().HoldOpening(pick_.opening_m());
    const Pose X_WG = hand().X_WG();
    const int opening =
        world().Steps(gripper_.TravelTime_s(pick_.opening_m() - hand().opening_m()));
    for (int i = 0; i < opening; ++i) pick_.Advance(X_WG);
    pick_.Move(pick_.Behind(X_WG), options_.approach_mps);
    const int maximum = world().Steps(options_.settle_s);
    for (int i = 0; i < maximum && !world().physics().AllAsleep(); ++i) pick_.Step();
  }

  // Applies the deciding rule. A failure by other rules may be a success by this one. A held target
  // may still fail it after it was set down; that is kMisplaced.
  void Judge(GraspOutcome& outcome) const {
    if (outcome.failure == FailureReason::kPhysicsFailed) return;
    outcome.verdicts = JudgeByAllRules(outcome, options_.rules);
    outcome.success = outcome.verdicts[static_cast<int>(options_.rule)];
    if (outcome.success) outcome.failure = FailureReason::kNone;
    if (!outcome.success && outcome.failure == FailureReason::kNone)
      outcome.failure = FailureReason::kMisplaced;
  }

  AttemptWorld& world() { return pick_.world(); }
  const AttemptWorld& world() const { return pick_.world(); }
  Hand& hand() { return pick_.hand(); }

  const Bin& bin_;
  const Gripper& gripper_;
  const GraspTarget target_;
  const ExecuteOptions& options_;
  PickUp pick_;
  PlacePlan place_;
  std::vector<int> carried_;  // positions of the instances in the hand at the end
};

}  // namespace

void ExecuteOptions::Visit(SettingsVisitor& v) {
  const Range seconds{0, 100}, speed{0.001, 10}, length{0, 10};
  v.Real("approach_mps", approach_mps, speed, "peak speed of the approach and the retreat, m/s");
  v.Real("stop_yield_m", stop_yield_m, {1e-5, 0.05},
         "movement of a pushed finger that counts as a collision, m");
  v.Real("stop_force_n", stop_force_n, {0.1, 1e5},
         "force of instances on palm or stem that counts as a collision, N");
  v.Real("stop_window_s", stop_window_s, {0.0001, 10},
         "time over which stop_force_n is averaged, s");
  v.Real("stop_depth_m", stop_depth_m, {0, 0.1},
         "depth of the palm in the bin or a static instance that counts as a collision, m");
  v.Real("close_s", close_s, seconds, "maximum wait until the fingers come to rest, s");
  v.Real("stalled_mps", stalled_mps, speed, "speed below which a finger has met the instance, m/s");
  v.Real("stalled_window_s", stalled_window_s, {0.001, 10},
         "time over which the speed of a finger is averaged, s");
  v.Real("lift_m", lift_m, length, "height of the lift, m; higher if the bin's rim requires it");
  v.Real("lift_s", lift_s, {0.01, 100},
         "duration of the lift, s; longer if the speed would exceed lift_mps");
  v.Real("lift_mps", lift_mps, speed, "peak vertical speed of the lift, m/s");
  v.Real("retreat_m", retreat_m, length,
         "height of the lift at which rule vgn_loose is evaluated, m");
  v.Real("hold_s", hold_s, seconds, "duration of the hold in the air, s");
  v.Real("shake_m", shake_m, {0, 1}, "amplitude of the shake, m");
  v.Real("shake_hz", shake_hz, {0.1, 100}, "frequency of the shake, Hz");
  v.Real("shake_s", shake_s, seconds, "duration of the shake, s");
  v.Bool("carry", carry,
         "whether the instance is carried to the table; else the attempt ends after the shake");
  v.Real("carry_mps", carry_mps, speed, "peak speed of the carry to the table, m/s");
  v.Real("settle_s", settle_s, seconds, "maximum time until the instances sleep again, s");
  v.RenamedKey("disturbed_m", "displaced_m");
  v.Real("displaced_m", displaced_m, length,
         "movement above which a neighbor counts as displaced, m");
  v.Group(
      "world", [this](SettingsVisitor& g) { world.Visit(g); },
      "bodies that move during an attempt");
  v.Group(
      "settle", [this](SettingsVisitor& g) { settle.Visit(g); },
      "settling of instances that an attempt left without support");
  v.Group(
      "place", [this](SettingsVisitor& g) { place.Visit(g); }, "placement of the picked object");
  v.Group(
      "rules", [this](SettingsVisitor& g) { rules.Visit(g); }, "thresholds of the success rules");
}

ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const Gripper& gripper, const GraspTarget& target,
                           const ExecuteOptions& options, const MotionListener& on_step) {
  CheckSettings("ExecuteOptions", options);
  CheckSettings("RetentionOptions", options.retention);
  CheckInput(grasp.X_WG.matrix().allFinite() && std::isfinite(grasp.width_m),
             "the pose or width of the grasp is not finite");
  ExecuteResult result = Attempt(scene, objects, grasp, gripper, target, options, on_step).Run();
  if (result.outcome.failure != FailureReason::kPhysicsFailed) {
    result.after =
        SettleDisturbed(scene, std::move(result.after), objects, options.settle, options.physics);
  }
  if (options.retention.max_g > 0 && result.outcome.success) {
    result.outcome.retention_g = Retention_g(scene, objects, grasp, gripper, target, options);
  }
  return result;
}

}  // namespace pickbed::grasp
