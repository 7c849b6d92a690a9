#include "grasp/execute/pick_up.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "grasp/place/hand_motion.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// The shake moves along all three axes at once, so that its direction favors no grasp.
const Vector3d kShakeDirection_W = Vector3d::Constant(1 / std::sqrt(3.0));

}  // namespace

PickUp::PickUp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
               const Gripper& gripper, const GraspTarget& target, const ExecuteOptions& options,
               const MotionListener& on_step)
    : bin_(scene.bin),
      gripper_(gripper),
      target_(target),
      options_(options),
      on_step_(on_step),
      lift_aside_m_(grasp.lift_aside_m),
      X_WG_(grasp.X_WG),
      opening_m_(gripper.OpeningOrMax_m(grasp.width_m)),
      boxes_(gripper.Boxes(opening_m_)),
      world_(scene, objects, X_WG_, boxes_, lift_aside_m_, target.instance, options.world,
             options.physics),
      hand_(gripper.AddTo(world_.physics(), opening_m_, Behind(X_WG_))) {
  hand_.HoldOpening(opening_m_);
}

void PickUp::ShowTable(const AxisAlignedBox& table_W) { table_W_ = table_W; }

FailureReason PickUp::Run(GraspOutcome& outcome) {
  if (IsUnderFloor() || !Approach()) return FailureReason::kCollision;
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

void PickUp::Step() {
  world_.Step();
  if (!on_step_) return;
  ++steps_;
  on_step_({steps_ * world_.physics().step_s(), world_, hand_, table_W_ ? &*table_W_ : nullptr});
}

void PickUp::Advance(const Pose& X_WG) {
  hand_.MoveTo(X_WG);
  Step();
}

Pose PickUp::Raised(double height_m) const {
  return Translation(LiftMotion(lift_aside_m_, height_m)) * X_WG_;
}

void PickUp::Move(const Pose& X_WG_to, double peak_mps) {
  const Pose from = hand_.X_WG();
  const double distance_m = (X_WG_to.translation() - from.translation()).norm();
  const int steps = world_.Steps(MinimumJerkSeconds(distance_m, peak_mps));
  for (int i = 1; i <= steps; ++i) {
    Advance(Between(from, X_WG_to, MinimumJerk(static_cast<double>(i) / steps)));
  }
}

// The contacts of the approach miss a hand that is under the floor from its start.
bool PickUp::IsUnderFloor() const {
  return X_WG_.translation().z() < -bin_.wall_m - options_.stop_depth_m;
}

// Returns false if the hand collides. The surface may be lower than planned: a cup that holds
// nothing at the planned pose moves on, as in a cell until the vacuum switch answers. Resistance
// ends this motion.
bool PickUp::Approach() {
  if (hand_.HoldsOnContact()) hand_.Close();
  const Pose planned_WG = X_WG_;
  if (!MoveUntilHeld(Behind(planned_WG), planned_WG, gripper_.approach_m)) return false;
  const double search_m = hand_.SearchTravel_m();
  if (search_m <= 0 || hand_.Holds()) return true;
  MoveUntilHeld(planned_WG, planned_WG * Translation({0, 0, search_m}), search_m);
  X_WG_ = hand_.X_WG();
  return true;
}

// Moves the hand over this distance, and stops where it holds on contact. Returns false if
// something in its way does not yield, or if the palm penetrates the bin or static instances. The
// palm feels no force from those, so its depth is checked.
bool PickUp::MoveUntilHeld(const Pose& X_WG_from, const Pose& X_WG_to, double distance_m) {
  const double share = std::min(1.0, world_.physics().step_s() / options_.stop_window_s);
  double felt_n = 0;
  const int steps = world_.Steps(MinimumJerkSeconds(distance_m, options_.approach_mps));
  for (int i = 1; i <= steps; ++i) {
    Advance(Between(X_WG_from, X_WG_to, MinimumJerk(static_cast<double>(i) / steps)));
    // To push on would press the held instance into the pile.
    if (hand_.HoldsOnContact() && hand_.Holds()) {
      X_WG_ = hand_.X_WG();
      return true;
    }
    felt_n += share * (hand_.Load().stiff_n - felt_n);
    if (felt_n > options_.stop_force_n || hand_.yielded_m() > options_.stop_yield_m) return false;
    if (world_.physics().HandIsInside(options_.stop_depth_m)) return false;
  }
  return true;
}

// Returns false if the fingers met each other, or if a cup did not seal.
bool PickUp::CloseOnInstance() {
  hand_.Close();
  const int window = world_.Steps(options_.stalled_window_s);
  const int maximum = world_.Steps(gripper_.TravelTime_s(opening_m_) + options_.close_s);
  double last = hand_.opening_m();
  for (int i = 1; i <= maximum; ++i) {
    Advance(X_WG_);
    if (i % window != 0) continue;
    const double speed = std::abs(last - hand_.opening_m()) / (window * world_.physics().step_s());
    last = hand_.opening_m();
    if (i > window && speed < options_.stalled_mps) break;
  }
  return hand_.Holds();
}

void PickUp::MarkLiftStart() {
  for (int i = 0; i < world_.instance_count(); ++i) {
    X_WO_lift_.push_back(world_.physics().X_WO(i));
  }
  X_WG_lift_ = hand_.X_WG();
  const double rim_m = bin_.inner_size_m.z();
  lift_m_ =
      std::max(options_.lift_m, rim_m + world_.reference_diameter_m() - X_WG_.translation().z());
}

void PickUp::Lift(GraspOutcome& outcome) {
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

void PickUp::Hold(GraspOutcome& outcome) {
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
void PickUp::Shake() {
  const int steps = world_.Steps(options_.shake_s);
  for (int i = 1; i <= steps; ++i) {
    const double periods = i * world_.physics().step_s() * options_.shake_hz;
    const double swing = std::min(1.0, periods) * std::sin(2 * std::numbers::pi * periods);
    Advance(Translation(options_.shake_m * swing * kShakeDirection_W) * Raised(lift_m_));
    WatchDrop();
  }
}

// Notes when the watched instance leaves the hand.
void PickUp::WatchDrop() {
  if (watched_ < 0 || drop_time_s_ >= 0) return;
  ++watched_steps_;
  if (IsInHand(watched_)) return;
  drop_time_s_ = watched_steps_ * world_.physics().step_s();
}

// Rise of the center of mass since the start of the lift.
double PickUp::Rise(int position) const {
  return Center(position).z() - world_.Center(position, X_WO_lift_[position]).z();
}

// Motion of the center of mass in G since the start of the lift.
double PickUp::ShiftInHand_m(int position) const {
  const Vector3d now_G = hand_.X_WG().inverse() * Center(position);
  return (now_G - X_WG_lift_.inverse() * world_.Center(position, X_WO_lift_[position])).norm();
}

std::vector<int> PickUp::Held() const {
  std::vector<int> held;
  if (X_WO_lift_.empty()) return held;
  for (int i = 0; i < world_.instance_count(); ++i) {
    if (!world_.IsStatic(i) && IsInHand(i)) held.push_back(i);
  }
  return held;
}

int PickUp::PickedOf(const std::vector<int>& held) const {
  for (const int position : held) {
    if (IsTarget(position)) return position;
  }
  return held.empty() ? -1 : held.front();
}

bool PickUp::IsTarget(int position) const {
  const PosedObject& posed = world_.Posed(position);
  if (target_.instance >= 0) return posed.instance == target_.instance;
  return target_.object < 0 || posed.object == target_.object;
}

void PickUp::RecordGrip(GraspOutcome& outcome) const {
  const int picked = PickedOf(Held());
  if (picked < 0) return;
  const Pose X_GO_lift = X_WG_lift_.inverse() * X_WO_lift_[picked];
  const Pose X_GO = hand_.X_WG().inverse() * world_.physics().X_WO(picked);
  const Vector3d& com_O = world_.ModelOf(picked).mass.com_O;
  outcome.slip_m = (X_GO * com_O - X_GO_lift * com_O).norm();
  outcome.in_hand_rotation_error_rad = RotationAngleRad(X_GO_lift.linear(), X_GO.linear());
}

}  // namespace pickbed::grasp
