#include "grasp/execute.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "grasp/hand_path.h"
#include "sim/hand_joints.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

// The shake goes along all three axes at once, so that no grasp is spared by its direction.
const Vector3d kShakeDirection_W = Vector3d::Constant(1 / std::sqrt(3.0));
class Attempt {
 public:
  Attempt(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
          const GripperSpec& gripper, const GraspTarget& target, const ExecuteOptions& options)
      : bin_(scene.bin),
        gripper_(gripper),
        mechanism_(MechanismOf(gripper)),
        target_(target),
        options_(options),
        X_WG_(grasp.X_WG),
        opening_m_(mechanism_.approach_opening_m(gripper, grasp.width_m)
                       .value_or(mechanism_.most_open_m(gripper))),
        boxes_(mechanism_.boxes(gripper, opening_m_)),
        world_(scene, objects, X_WG_.translation(), target.instance, options.world,
               options.physics),
        hand_(mechanism_.add(world_.physics(), gripper, opening_m_, Behind(X_WG_))) {
    hand_.HoldOpening(opening_m_);
  }

  ExecuteResult Run() {
    ExecuteResult result;
    GraspOutcome& outcome = result.outcome;
    outcome.loss = Try(outcome);
    if (outcome.loss != Loss::kPhysicsFailed && carried_.empty()) Withdraw();
    if (world_.physics().BlewUp()) outcome.loss = Loss::kPhysicsFailed;
    Judge(outcome);
    const bool failed = outcome.loss == Loss::kPhysicsFailed;
    result.after = failed ? world_.snapshot() : world_.Remaining(carried_);
    if (!failed) {
      outcome.disturbed = world_.Displaced(options_.disturbed_m, carried_, target_.instance);
    }
    return result;
  }

 private:
  Vector3d Center(int part) const { return world_.Center(part, world_.physics().X_WO(part)); }

  // Where the straight approach to a pose begins.
  Pose Behind(const Pose& X_WG) const { return X_WG * Translation({0, 0, -gripper_.approach_m}); }

  Pose Raised(double height_m) const { return Translation({0, 0, height_m}) * X_WG_; }

  Loss Try(GraspOutcome& outcome) {
    if (!Approach()) return Loss::kCollision;
    const bool closed_on_part = CloseOnPart();
    outcome.parts_touched = static_cast<int>(world_.physics().PartsTouchingHand().size());
    if (!closed_on_part) return Loss::kClosedOnNothing;
    MarkLiftStart();
    outcome.final_opening_m = hand_.opening_m();
    Lift(outcome);
    if (world_.physics().BlewUp()) return Loss::kPhysicsFailed;
    outcome.parts_risen = static_cast<int>(Held().size());
    if (outcome.parts_risen == 0) return Loss::kSlipped;
    Hold(outcome);
    Shake();
    if (world_.physics().BlewUp()) return Loss::kPhysicsFailed;
    outcome.final_opening_m = hand_.opening_m();
    RecordGrip(outcome);
    const int picked = PickedOf(Held());
    if (options_.carry && picked >= 0) Carry(picked);
    if (world_.physics().BlewUp()) return Loss::kPhysicsFailed;
    carried_ = Held();
    const Loss loss = JudgeHeld(outcome);
    if (options_.carry && loss == Loss::kNone) SetDown(carried_.front(), outcome);
    return loss;
  }

  // One step towards a pose; nothing but the palm is told where to go.
  void Advance(const Pose& X_WG) {
    hand_.MoveTo(X_WG);
    world_.Step();
  }

  void Move(const Pose& X_WG_to, double peak_mps) {
    const Pose from = hand_.X_WG();
    const double distance_m = (X_WG_to.translation() - from.translation()).norm();
    const int steps = world_.Steps(MinimumJerkSeconds(distance_m, peak_mps));
    for (int i = 1; i <= steps; ++i) {
      Advance(Between(from, X_WG_to, MinimumJerk(static_cast<double>(i) / steps)));
    }
  }

  // False when the hand meets more than the stopping force on the way, or its palm, which feels no
  // force from what cannot give way, gets into bin or static parts.
  bool Approach() {
    const double share = std::min(1.0, world_.physics().step_s() / options_.stop_window_s);
    double felt_n = 0;
    const int steps = world_.Steps(MinimumJerkSeconds(gripper_.approach_m, options_.approach_mps));
    for (int i = 1; i <= steps; ++i) {
      Advance(Between(Behind(X_WG_), X_WG_, MinimumJerk(static_cast<double>(i) / steps)));
      felt_n += share * (hand_.Load().hardest_n - felt_n);
      if (felt_n > options_.stop_force_n) return false;
      if (world_.physics().PalmIsInside(options_.stop_depth_m)) return false;
    }
    return true;
  }

  // False when the fingers met each other, or a cup did not seal.
  bool CloseOnPart() {
    hand_.Close();
    const int window = world_.Steps(options_.stalled_window_s);
    const int most = world_.Steps(mechanism_.travel_s(gripper_, opening_m_) + options_.close_s);
    double last = hand_.opening_m();
    for (int i = 1; i <= most; ++i) {
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
    for (int i = 0; i < world_.part_count(); ++i) {
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
      outcome.retreat_contact = !world_.physics().PartsTouchingHand().empty();
      const double most_m = mechanism_.most_open_m(gripper_);
      outcome.retreat_opening = most_m > 0 ? hand_.opening_m() / most_m : hand_.Holds();
    }
    for (int i = 0; i < world_.part_count(); ++i) {
      if (world_.IsStatic(i)) continue;
      outcome.lift_height_m = std::max(outcome.lift_height_m, Rise(i));
    }
  }

  void Hold(GraspOutcome& outcome) {
    const int steps = world_.Steps(options_.hold_s), counted = std::max(1, steps / 2);
    for (int i = 0; i < steps; ++i) {
      Advance(Raised(lift_m_));
      if (i < steps - counted) continue;
      const HandLoad load = hand_.Load();
      outcome.contact_force_n += load.force_n / counted;
      outcome.contact_torque_nm += load.torque_nm / counted;
    }
  }

  // A sine that swells over its first period, since a kinematic palm must not jump to full speed.
  void Shake() {
    const int steps = world_.Steps(options_.shake_s);
    for (int i = 1; i <= steps; ++i) {
      const double periods = i * world_.physics().step_s() * options_.shake_hz;
      const double swing = std::min(1.0, periods) * std::sin(2 * std::numbers::pi * periods);
      Advance(Translation(options_.shake_m * swing * kShakeDirection_W) * Raised(lift_m_));
    }
  }

  // Of a part's centre since the start of the lift.
  double Rise(int part) const {
    return Center(part).z() - world_.Center(part, X_WO_lift_[part]).z();
  }

  // How far a part's centre has moved in the hand since the start of the lift.
  double ShiftInHand_m(int part) const {
    const Vector3d now_G = hand_.X_WG().inverse() * Center(part);
    return (now_G - X_WG_lift_.inverse() * world_.Center(part, X_WO_lift_[part])).norm();
  }

  // Parts that have come with the hand, by index: those that stayed behind by less than half of the
  // lift.
  std::vector<int> Held() const {
    std::vector<int> held;
    if (X_WO_lift_.empty()) return held;
    for (int i = 0; i < world_.part_count(); ++i) {
      if (!world_.IsStatic(i) && ShiftInHand_m(i) < 0.5 * lift_m_) held.push_back(i);
    }
    return held;
  }

  // The one that was meant, or the first; -1 = none.
  int PickedOf(const std::vector<int>& held) const {
    for (const int part : held) {
      if (IsTarget(part)) return part;
    }
    return held.empty() ? -1 : held.front();
  }

  bool IsTarget(int part) const {
    const PosedObject& posed = world_.Posed(part);
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
    outcome.turn_rad = RotationAngleRad(X_GO_lift.linear(), X_GO.linear());
  }

  // Up until hand and part clear the rim, and then to over the table.
  void Carry(int picked) {
    const PosedObject& posed = world_.Posed(picked);
    const ObjectModel& model = world_.ModelOf(picked);
    const Pose X_WO = target_.X_WO.value_or(posed.X_WO);
    place_ = PlanPlace(bin_, model, X_WO, X_WG_, boxes_, options_.place);
    world_.physics().AddStaticBox(Translation(place_.table_W.center), place_.table_W.half_size,
                                  bin_.friction);
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
    outcome.set_down = true;
    outcome.place_error_m = error.distance_m;
    outcome.place_turn_rad = error.turn_rad;
  }

  // Straight down until the table takes some of the load, or to the end of the way.
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

  Loss JudgeHeld(GraspOutcome& outcome) const {
    outcome.parts_lifted = static_cast<int>(carried_.size());
    if (carried_.empty()) return Loss::kDropped;
    const int picked = PickedOf(carried_);
    outcome.picked_instance = world_.Posed(picked).instance;
    outcome.is_target = IsTarget(picked);
    if (carried_.size() > 1) return Loss::kTookTwo;
    return outcome.is_target ? Loss::kNone : Loss::kWrongPart;
  }

  // Opens to as far as it was on approach; a part between the fingers must not be dragged along.
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
    const int last = world_.Steps(mechanism_.travel_s(gripper_, opening_m_ - hand_.opening_m()));
    for (int i = 0; i < last; ++i) Advance(X_WG);
  }

  // Opens, backs off along the approach and lets the parts come to rest.
  void Withdraw() {
    hand_.HoldOpening(opening_m_);
    const Pose X_WG = hand_.X_WG();
    const int opening = world_.Steps(mechanism_.travel_s(gripper_, opening_m_ - hand_.opening_m()));
    for (int i = 0; i < opening; ++i) Advance(X_WG);
    Move(Behind(X_WG), options_.approach_mps);
    const int most = world_.Steps(options_.settle_s);
    for (int i = 0; i < most && !world_.physics().AllAsleep(); ++i) world_.Step();
  }

  // By the rule that decides. What the other rules count as lost may be a success by it, and what
  // is in the hand may yet fail it where it was set down: that is misplaced.
  void Judge(GraspOutcome& outcome) const {
    if (outcome.loss == Loss::kPhysicsFailed) return;
    outcome.verdicts = JudgeByAllRules(outcome, options_.rules);
    outcome.success = outcome.verdicts[static_cast<int>(options_.rule)];
    if (outcome.success) outcome.loss = Loss::kNone;
    if (!outcome.success && outcome.loss == Loss::kNone) outcome.loss = Loss::kMisplaced;
  }

  const Bin& bin_;
  const GripperSpec& gripper_;
  const MechanismRow& mechanism_;
  const GraspTarget target_;
  const ExecuteOptions& options_;
  const Pose X_WG_;
  const double opening_m_;
  const std::vector<AxisAlignedBox> boxes_;  // of the hand so open, in G
  AttemptWorld world_;
  Hand& hand_;
  double lift_m_ = 0;
  std::vector<int> carried_;  // parts in the hand at the end, by index
  PlacePlan place_;
  // At the start of the lift; empty before.
  std::vector<Pose> X_WO_lift_;
  Pose X_WG_lift_ = Pose::Identity();
};

}  // namespace

void ExecuteOptions::Visit(SettingsVisitor& v) {
  const Range seconds{0, 100}, speed{0.001, 10}, length{0, 10};
  v.Real("approach_mps", approach_mps, speed, "largest speed of approach and of drawing back, m/s");
  v.Real("stop_force_n", stop_force_n, {0.1, 1e5}, "on a body of the hand: collision, N");
  v.Real("stop_window_s", stop_window_s, {0.0001, 10}, "of the mean of that force, s");
  v.Real("stop_depth_m", stop_depth_m, {0, 0.1}, "of the palm in what cannot give way, m");
  v.Real("close_s", close_s, seconds, "waited at most for the fingers to come to rest, s");
  v.Real("stalled_mps", stalled_mps, speed, "fingers slower than this have met the part, m/s");
  v.Real("stalled_window_s", stalled_window_s, {0.001, 10}, "that their speed is taken over, s");
  v.Real("lift_m", lift_m, length, "more where the bin's rim is higher, m");
  v.Real("lift_s", lift_s, {0.01, 100}, "longer where that is faster than lift_mps, s");
  v.Real("lift_mps", lift_mps, speed, "largest speed of the lift, m/s");
  v.Real("retreat_m", retreat_m, length, "of the lift, for the loose rule, m");
  v.Real("hold_s", hold_s, seconds, "standing still in the air, s");
  v.Real("shake_m", shake_m, {0, 1}, "amplitude, m");
  v.Real("shake_hz", shake_hz, {0.1, 100}, "of the shake, Hz");
  v.Real("shake_s", shake_s, seconds, "of the shake, s");
  v.Bool("carry", carry, "out of the bin to the table; else it ends with the shake");
  v.Real("carry_mps", carry_mps, speed, "largest speed on the way to the table, m/s");
  v.Real("settle_s", settle_s, seconds, "at most until parts sleep again, s");
  v.Real("disturbed_m", disturbed_m, length, "a neighbour that moved further is disturbed, m");
  v.Group(
      "world", [this](SettingsVisitor& g) { world.Visit(g); }, "what moves");
  v.Group(
      "place", [this](SettingsVisitor& g) { place.Visit(g); }, "how it is set down");
  v.Group(
      "rules", [this](SettingsVisitor& g) { rules.Visit(g); }, "of success");
}

ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const GripperSpec& gripper, const GraspTarget& target,
                           const ExecuteOptions& options) {
  return Attempt(scene, objects, grasp, gripper, target, options).Run();
}

}  // namespace pickbed
