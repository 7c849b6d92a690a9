#include "grasp/execute/execute.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "grasp/place/hand_motion.h"
#include "sim/hands/hand.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// The shake moves along all three axes at once, so that its direction favors no grasp.
const Vector3d kShakeDirection_W = Vector3d::Constant(1 / std::sqrt(3.0));
class Attempt {
 public:
  Attempt(const Scene& scene, const ObjectSet& objects, const Grasp& grasp, const Gripper& gripper,
          const GraspTarget& target, const ExecuteOptions& options, const MotionListener& on_step)
      : bin_(scene.bin),
        gripper_(gripper),
        target_(target),
        options_(options),
        on_step_(on_step),
        X_WG_(grasp.X_WG),
        opening_m_(gripper.ApproachOpening_m(grasp.width_m).value_or(gripper.MaxOpening_m())),
        boxes_(gripper.Boxes(opening_m_)),
        world_(scene, objects, X_WG_, boxes_, target.instance, options.world, options.physics),
        hand_(gripper.AddTo(world_.physics(), opening_m_, Behind(X_WG_))) {
    hand_.HoldOpening(opening_m_);
  }

  // Returns the load of the hold test at which the instance leaves the hand, in multiples of g.
  double Retention_g() {
    GraspOutcome outcome;
    if (PickUp(outcome) != FailureReason::kNone) return 0;
    const int picked = PickedOf(Held());
    if (picked < 0) return 0;
    return LoadUntilLost_g(
        world_, hand_, picked, options_.retention, options_.physics.gravity_W,
        [&] { Advance(Raised(lift_m_)); }, [&] { return !hand_.Holds() || !IsInHand(picked); });
  }

  ExecuteResult Run() {
    ExecuteResult result;
    GraspOutcome& outcome = result.outcome;
    outcome.failure = Try(outcome);
    if (outcome.failure != FailureReason::kPhysicsFailed && carried_.empty()) Withdraw();
    if (world_.physics().BlewUp()) outcome.failure = FailureReason::kPhysicsFailed;
    Judge(outcome);
    const bool failed = outcome.failure == FailureReason::kPhysicsFailed;
    result.after = failed ? world_.snapshot() : world_.Remaining(carried_);
    if (!failed) {
      outcome.neighbors_displaced =
          world_.Displaced(options_.displaced_m, carried_, target_.instance);
    }
    return result;
  }

 private:
  Vector3d Center(int position) const {
    return world_.Center(position, world_.physics().X_WO(position));
  }

  // Start of the straight approach to a pose.
  Pose Behind(const Pose& X_WG) const { return X_WG * Translation({0, 0, -gripper_.approach_m}); }

  Pose Raised(double height_m) const { return Translation({0, 0, height_m}) * X_WG_; }

  // Approach, lift, hold and shake. kNone does not say that an instance is in the hand.
  FailureReason PickUp(GraspOutcome& outcome) {
    if (!Approach()) return FailureReason::kCollision;
    const bool closed_on_instance = CloseOnInstance();
    outcome.instances_touched = static_cast<int>(world_.physics().InstancesTouchingHand().size());
    if (!closed_on_instance) return FailureReason::kClosedOnNothing;
    MarkLiftStart();
    outcome.final_opening_m = hand_.opening_m();
    Lift(outcome);
    if (world_.physics().BlewUp()) return FailureReason::kPhysicsFailed;
    outcome.instances_risen = static_cast<int>(Held().size());
    if (outcome.instances_risen == 0) return FailureReason::kSlipped;
    watched_ = options_.retention.max_g > 0 ? PickedOf(Held()) : -1;
    Hold(outcome);
    Shake();
    outcome.drop_time_s = drop_time_s_;
    return world_.physics().BlewUp() ? FailureReason::kPhysicsFailed : FailureReason::kNone;
  }

  FailureReason Try(GraspOutcome& outcome) {
    const FailureReason lost = PickUp(outcome);
    if (lost != FailureReason::kNone) return lost;
    outcome.final_opening_m = hand_.opening_m();
    RecordGrip(outcome);
    const int picked = PickedOf(Held());
    if (options_.carry && picked >= 0) Carry(picked);
    if (world_.physics().BlewUp()) return FailureReason::kPhysicsFailed;
    carried_ = Held();
    const FailureReason failure = JudgeHeld(outcome);
    if (options_.carry && failure == FailureReason::kNone) SetDown(carried_.front(), outcome);
    return failure;
  }

  // Makes one step towards a pose. Only the palm is driven.
  void Advance(const Pose& X_WG) {
    hand_.MoveTo(X_WG);
    Step();
  }

  void Step() {
    world_.Step();
    if (!on_step_) return;
    ++steps_;
    on_step_({steps_ * world_.physics().step_s(), world_, hand_,
              has_table_ ? &place_.table_W : nullptr});
  }

  void Move(const Pose& X_WG_to, double peak_mps) {
    const Pose from = hand_.X_WG();
    const double distance_m = (X_WG_to.translation() - from.translation()).norm();
    const int steps = world_.Steps(MinimumJerkSeconds(distance_m, peak_mps));
    for (int i = 1; i <= steps; ++i) {
      Advance(Between(from, X_WG_to, MinimumJerk(static_cast<double>(i) / steps)));
    }
  }

  // Returns false if something in the way of the hand does not yield, or if the palm penetrates the
  // bin or static instances. The palm feels no force from those, so its depth is checked.
  bool Approach() {
    const double share = std::min(1.0, world_.physics().step_s() / options_.stop_window_s);
    double felt_n = 0;
    const int steps = world_.Steps(MinimumJerkSeconds(gripper_.approach_m, options_.approach_mps));
    for (int i = 1; i <= steps; ++i) {
      Advance(Between(Behind(X_WG_), X_WG_, MinimumJerk(static_cast<double>(i) / steps)));
      felt_n += share * (hand_.Load().stiff_n - felt_n);
      if (felt_n > options_.stop_force_n || hand_.yielded_m() > options_.stop_yield_m) return false;
      if (world_.physics().HandIsInside(options_.stop_depth_m)) return false;
    }
    return true;
  }

  // Returns false if the fingers met each other, or if a cup did not seal.
  bool CloseOnInstance() {
    hand_.Close();
    const int window = world_.Steps(options_.stalled_window_s);
    const int maximum = world_.Steps(gripper_.TravelTime_s(opening_m_) + options_.close_s);
    double last = hand_.opening_m();
    for (int i = 1; i <= maximum; ++i) {
      Advance(X_WG_);
      if (i % window != 0) continue;
      const double speed =
          std::abs(last - hand_.opening_m()) / (window * world_.physics().step_s());
      last = hand_.opening_m();
      if (i > window && speed < options_.stalled_mps) break;
    }
    return hand_.Holds();
  }

  void MarkLiftStart() {
    for (int i = 0; i < world_.instance_count(); ++i) {
      X_WO_lift_.push_back(world_.physics().X_WO(i));
    }
    X_WG_lift_ = hand_.X_WG();
    const double rim_m = bin_.inner_size_m.z();
    lift_m_ =
        std::max(options_.lift_m, rim_m + world_.reference_diameter_m() - X_WG_.translation().z());
  }

  void Lift(GraspOutcome& outcome) {
    const double lift_s = std::max(options_.lift_s, MinimumJerkSeconds(lift_m_, options_.lift_mps));
    const int steps = world_.Steps(lift_s);
    const double retreat_m = std::min(options_.retreat_m, lift_m_);
    bool is_back = false;
    for (int i = 1; i <= steps; ++i) {
      const double height_m = lift_m_ * MinimumJerk(static_cast<double>(i) / steps);
      Advance(Raised(height_m));
      if (is_back || height_m < retreat_m) continue;
      is_back = true;
      outcome.retreat_contact = !world_.physics().InstancesTouchingHand().empty();
      const double max_m = gripper_.MaxOpening_m();
      outcome.retreat_opening = max_m > 0 ? hand_.opening_m() / max_m : hand_.Holds();
    }
    for (int i = 0; i < world_.instance_count(); ++i) {
      if (world_.IsStatic(i)) continue;
      outcome.lift_height_m = std::max(outcome.lift_height_m, Rise(i));
    }
  }

  void Hold(GraspOutcome& outcome) {
    const int steps = world_.Steps(options_.hold_s), counted = std::max(1, steps / 2);
    held_steps_ = steps;
    touched_steps_.assign(world_.instance_count(), 0);
    for (int i = 0; i < steps; ++i) {
      Advance(Raised(lift_m_));
      WatchDrop();
      for (const int position : world_.physics().InstancesTouchingHand()) {
        ++touched_steps_[position];
      }
      if (i < steps - counted) continue;
      const HandLoad load = hand_.Load();
      outcome.contact_force_n += load.force_n / counted;
      outcome.contact_torque_nm += load.torque_nm / counted;
    }
  }

  // The amplitude grows over the first period, because a kinematic palm must not jump to full
  // speed.
  void Shake() {
    const int steps = world_.Steps(options_.shake_s);
    for (int i = 1; i <= steps; ++i) {
      const double periods = i * world_.physics().step_s() * options_.shake_hz;
      const double swing = std::min(1.0, periods) * std::sin(2 * std::numbers::pi * periods);
      Advance(Translation(options_.shake_m * swing * kShakeDirection_W) * Raised(lift_m_));
      WatchDrop();
    }
  }

  // Notes when the watched instance leaves the hand.
  void WatchDrop() {
    if (watched_ < 0 || drop_time_s_ >= 0) return;
    ++watched_steps_;
    if (IsInHand(watched_)) return;
    drop_time_s_ = watched_steps_ * world_.physics().step_s();
  }

  bool IsInHand(int position) const { return ShiftInHand_m(position) < 0.5 * lift_m_; }

  // Rise of the center of mass since the start of the lift.
  double Rise(int position) const {
    return Center(position).z() - world_.Center(position, X_WO_lift_[position]).z();
  }

  // Motion of the center of mass in G since the start of the lift.
  double ShiftInHand_m(int position) const {
    const Vector3d now_G = hand_.X_WG().inverse() * Center(position);
    return (now_G - X_WG_lift_.inverse() * world_.Center(position, X_WO_lift_[position])).norm();
  }

  // Indices of instances that moved with the hand: they shifted in G by less than half of the lift.
  std::vector<int> Held() const {
    std::vector<int> held;
    if (X_WO_lift_.empty()) return held;
    for (int i = 0; i < world_.instance_count(); ++i) {
      if (!world_.IsStatic(i) && IsInHand(i)) held.push_back(i);
    }
    return held;
  }

  // The target if it is in the hand, else the first; -1 = none.
  int PickedOf(const std::vector<int>& held) const {
    for (const int position : held) {
      if (IsTarget(position)) return position;
    }
    return held.empty() ? -1 : held.front();
  }

  bool IsTarget(int position) const {
    const PosedObject& posed = world_.Posed(position);
    if (target_.instance >= 0) return posed.instance == target_.instance;
    return target_.object < 0 || posed.object == target_.object;
  }

  void RecordGrip(GraspOutcome& outcome) const {
    const int picked = PickedOf(Held());
    if (picked < 0) return;
    const Pose X_GO_lift = X_WG_lift_.inverse() * X_WO_lift_[picked];
    const Pose X_GO = hand_.X_WG().inverse() * world_.physics().X_WO(picked);
    const Vector3d& com_O = world_.ModelOf(picked).mass.com_O;
    outcome.slip_m = (X_GO * com_O - X_GO_lift * com_O).norm();
    outcome.in_hand_rotation_error_rad = RotationAngleRad(X_GO_lift.linear(), X_GO.linear());
  }

  // Moves up until hand and object clear the rim, then to above the table.
  void Carry(int picked) {
    const PosedObject& posed = world_.Posed(picked);
    const ObjectModel& model = world_.ModelOf(picked);
    const Pose X_WO = target_.X_WO.value_or(posed.X_WO);
    place_ = PlanPlace(bin_, model, X_WO, X_WG_, boxes_, options_.place);
    world_.physics().AddStaticBox(Translation(place_.table_W.center), place_.table_W.half_size,
                                  bin_.friction);
    has_table_ = true;
    Pose up = Raised(lift_m_), over = place_.X_WG;
    const double height_m = std::max(
        up.translation().z(),
        CarryHeight_m(bin_, model, X_WG_.inverse() * X_WO, up, over, boxes_, options_.place));
    up.translation().z() = over.translation().z() = height_m;
    Move(up, options_.carry_mps);
    Move(over, options_.carry_mps);
  }

  void SetDown(int picked, GraspOutcome& outcome) {
    Move(Translation({0, 0, options_.place.slow_m}) * place_.X_WG, options_.place.lower_mps);
    LowerUntilTouch();
    LetGo(options_.place.release_mps);
    Withdraw();
    const PlaceError error =
        PlaceErrorOf(world_.ModelOf(picked), place_.X_WO, world_.physics().X_WO(picked));
    outcome.place_executed = true;
    outcome.place_error_m = error.distance_m;
    outcome.place_rotation_error_rad = error.rotation_error_rad;
  }

  // Descends until the table takes some of the load, or to the end of the path.
  void LowerUntilTouch() {
    const PlaceOptions& place = options_.place;
    const double share = std::min(1.0, world_.physics().step_s() / options_.stop_window_s);
    const Pose from = hand_.X_WG();
    double felt_n = UpwardLoad_n();
    for (int i = 0; i < world_.Steps(place.steady_s); ++i) {
      Advance(from);
      felt_n += share * (UpwardLoad_n() - felt_n);
    }
    const double weight_n = felt_n;
    const double way_m = place.slow_m + place_.overtravel_m;
    const int steps = world_.Steps(way_m / place.slow_mps);
    for (int i = 1; i <= steps; ++i) {
      Advance(Translation({0, 0, -way_m * i / steps}) * from);
      felt_n += share * (UpwardLoad_n() - felt_n);
      if (felt_n - weight_n > place.touch_n) return;
    }
  }

  double UpwardLoad_n() const { return (hand_.X_WG().linear() * hand_.Load().force_n).z(); }

  // Whether the hand touched the instance for at least half of the hold. An instance that is hooked
  // on another one may swing against the hand.
  bool IsGripped(int position) const { return 2 * touched_steps_[position] >= held_steps_; }

  FailureReason JudgeHeld(GraspOutcome& outcome) const {
    outcome.instances_lifted = static_cast<int>(carried_.size());
    if (carried_.empty()) return FailureReason::kDropped;
    const int picked = PickedOf(carried_);
    outcome.picked_instance = world_.Posed(picked).instance;
    outcome.is_target = IsTarget(picked);
    const auto entangled = std::count_if(carried_.begin(), carried_.end(), [&](int position) {
      return position != picked && !IsGripped(position);
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
    const Pose X_WG = hand_.X_WG();
    const double from_m = hand_.opening_m();
    const double way_m = std::max(0.0, opening_m_ - from_m);
    const int steps = world_.Steps(0.5 * way_m / finger_mps);
    for (int i = 1; i <= steps; ++i) {
      hand_.HoldOpening(from_m + way_m * i / steps);
      Advance(X_WG);
    }
    hand_.HoldOpening(opening_m_);
    const int last = world_.Steps(gripper_.TravelTime_s(opening_m_ - hand_.opening_m()));
    for (int i = 0; i < last; ++i) Advance(X_WG);
  }

  // Opens, retreats along the approach and lets the instances come to rest.
  void Withdraw() {
    hand_.HoldOpening(opening_m_);
    const Pose X_WG = hand_.X_WG();
    const int opening = world_.Steps(gripper_.TravelTime_s(opening_m_ - hand_.opening_m()));
    for (int i = 0; i < opening; ++i) Advance(X_WG);
    Move(Behind(X_WG), options_.approach_mps);
    const int maximum = world_.Steps(options_.settle_s);
    for (int i = 0; i < maximum && !world_.physics().AllAsleep(); ++i) Step();
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

  const Bin& bin_;
  const Gripper& gripper_;
  const GraspTarget target_;
  const ExecuteOptions& options_;
  const MotionListener& on_step_;
  int steps_ = 0;  // reported to on_step_
  const Pose X_WG_;
  const double opening_m_;
  const std::vector<AxisAlignedBox> boxes_;  // of the hand at opening_m_, in G
  AttemptWorld world_;
  Hand& hand_;
  double lift_m_ = 0;
  std::vector<int> carried_;  // indices of instances in the hand at the end
  // By index: number of steps of the hold in which the hand touched the instance.
  std::vector<int> touched_steps_;
  int held_steps_ = 0;
  int watched_ = -1;  // index of the instance whose drop is timed, -1 = none
  int watched_steps_ = 0;
  double drop_time_s_ = -1;
  PlacePlan place_;
  bool has_table_ = false;  // place_ is planned
  // Poses at the start of the lift; empty before.
  std::vector<Pose> X_WO_lift_;
  Pose X_WG_lift_ = Pose::Identity();
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
  v.Real("lift_mps", lift_mps, speed, "peak speed of the lift, m/s");
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
  ExecuteResult result = Attempt(scene, objects, grasp, gripper, target, options, on_step).Run();
  if (result.outcome.failure != FailureReason::kPhysicsFailed) {
    result.after =
        SettleDisturbed(scene, std::move(result.after), objects, options.settle, options.physics);
  }
  if (options.retention.max_g > 0 && result.outcome.success) {
    result.outcome.retention_g =
        Attempt(scene, objects, grasp, gripper, target, options, {}).Retention_g();
  }
  return result;
}

}  // namespace pickbed::grasp
