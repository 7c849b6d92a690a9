#include "grasp/execute.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/hand_joints.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

// The shake goes along all three axes at once, so that no grasp is spared by its direction.
const Vector3d kShakeDirection_W = Vector3d::Constant(1 / std::sqrt(3.0));
// The fingers' speed is judged over this time, longer than the first steps of their acceleration.
constexpr double kStallWindow_s = 0.05;

// Rest-to-rest path of least jerk (Flash and Hogan 1985), 0..1 over 0..1.
double MinimumJerk(double t) { return t * t * t * (10 + t * (6 * t - 15)); }

// How long such a path takes that reaches this speed in its middle.
double MinimumJerkSeconds(double distance_m, double peak_mps) {
  return 1.875 * distance_m / peak_mps;
}

Pose Between(const Pose& from, const Pose& to, double share) {
  const Eigen::Quaterniond start(from.linear()), end(to.linear());
  return MakePose(start.slerp(share, end).toRotationMatrix(),
                  (1 - share) * from.translation() + share * to.translation());
}

class Attempt {
 public:
  Attempt(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
          const GripperSpec& gripper, const GraspTarget& target, const ExecuteOptions& options)
      : scene_(scene),
        objects_(objects),
        gripper_(gripper),
        target_(target),
        options_(options),
        X_WG_(grasp.X_WG),
        world_(options.physics) {
    const auto opening = MechanismOf(gripper).approach_opening_m(gripper, grasp.width_m);
    opening_m_ = opening.value_or(gripper.hand.stroke_m);
    AddParts();
    // A hand starts as open as its stroke lets it: its sliders' end stop is where it shall start.
    GripperSpec hand = gripper;
    hand.hand.stroke_m = opening_m_;
    hand_ =
        &MechanismOf(gripper).add(world_, hand, X_WG_ * Translation({0, 0, -gripper.approach_m}));
    hand_->HoldOpening(opening_m_);
  }

  ExecuteResult Run() {
    ExecuteResult result;
    GraspOutcome& outcome = result.outcome;
    outcome.loss = Try(outcome);
    if (outcome.loss != Loss::kPhysicsFailed && carried_.empty()) Withdraw();
    if (world_.BlewUp()) outcome.loss = Loss::kPhysicsFailed;
    Judge(outcome);
    Conclude(result);
    return result;
  }

 private:
  Vector3d Center(int part, const Pose& X_WO) const {
    return X_WO * objects_[scene_.objects[part].object]->mass.com_O;
  }

  double Diameter(int part) const { return objects_[scene_.objects[part].object]->diameter_m; }

  // The part that the grasp is about: the target, or the one nearest to the closing fingers.
  int ReferencePart(const Vector3d& grasp_point) const {
    int nearest = -1;
    double nearest_distance = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < scene_.objects.size(); ++i) {
      if (scene_.objects[i].instance == target_.instance) return static_cast<int>(i);
      const double distance = (Center(i, scene_.objects[i].X_WO) - grasp_point).norm();
      if (distance < nearest_distance) {
        nearest_distance = distance;
        nearest = static_cast<int>(i);
      }
    }
    return nearest;
  }

  // Every part in the scene's order; those that neither the target nor the hand can move are
  // static.
  void AddParts() {
    world_.AddBin(scene_.bin);
    const Vector3d grasp_point = X_WG_.translation();
    const int reference = ReferencePart(grasp_point);
    for (size_t i = 0; i < scene_.objects.size(); ++i) {
      const PosedObject& part = scene_.objects[i];
      const Vector3d center = Center(i, part.X_WO);
      const double radius = 0.5 * Diameter(i) + options_.near_m;
      const Vector3d reference_center = Center(reference, scene_.objects[reference].X_WO);
      const bool near_reference =
          (center - reference_center).norm() < radius + 0.5 * Diameter(reference);
      const bool near =
          options_.all_active || near_reference || (center - grasp_point).norm() < radius;
      const BodyMode moving = options_.all_active ? BodyMode::kDynamic : BodyMode::kAsleep;
      world_.AddPart(*objects_.at(part.object), part.X_WO, near ? moving : BodyMode::kStatic);
      is_static_.push_back(!near);
      is_lost_.push_back(false);
    }
    reference_diameter_m_ = reference < 0 ? 0 : Diameter(reference);
  }

  // What falls past the floor falls for ever: it is taken out before its speed looks like a fault.
  void Step() {
    world_.Step();
    for (int i = 0; i < world_.part_count(); ++i) {
      if (is_lost_[i] || world_.X_WO(i).translation().z() > -options_.lost_below_m) continue;
      world_.RemovePart(i);
      is_lost_[i] = true;
    }
  }

  int Steps(double seconds) const {
    return static_cast<int>(std::lround(seconds / world_.step_s()));
  }

  Pose Raised(double height_m) const { return Translation({0, 0, height_m}) * X_WG_; }

  Loss Try(GraspOutcome& outcome) {
    if (!Approach()) return Loss::kCollision;
    const bool closed_on_part = CloseOnPart();
    outcome.parts_touched = static_cast<int>(world_.PartsTouchingHand().size());
    if (!closed_on_part) return Loss::kClosedOnNothing;
    MarkLiftStart();
    outcome.final_opening_m = hand_->opening_m();
    Lift(outcome);
    if (world_.BlewUp()) return Loss::kPhysicsFailed;
    outcome.parts_risen = static_cast<int>(Held().size());
    if (outcome.parts_risen == 0) return Loss::kSlipped;
    Hold(outcome);
    Shake();
    if (world_.BlewUp()) return Loss::kPhysicsFailed;
    outcome.final_opening_m = hand_->opening_m();
    RecordGrip(outcome);
    const int picked = PickedOf(Held());
    if (options_.carry && picked >= 0) Carry(picked);
    if (world_.BlewUp()) return Loss::kPhysicsFailed;
    carried_ = Held();
    const Loss loss = JudgeHeld(outcome);
    if (options_.carry && loss == Loss::kNone) SetDown(carried_.front(), outcome);
    return loss;
  }

  // A motion from where the hand stands; nothing but the palm is told where to go.
  void Move(const Pose& X_WG_to, double peak_mps) {
    const Pose from = hand_->X_WG();
    const double distance_m = (X_WG_to.translation() - from.translation()).norm();
    const int steps = Steps(MinimumJerkSeconds(distance_m, peak_mps));
    for (int i = 1; i <= steps; ++i) {
      hand_->MoveTo(Between(from, X_WG_to, MinimumJerk(static_cast<double>(i) / steps)));
      Step();
    }
  }

  // False when something in the hand's way does not give way to it.
  bool Approach() {
    const double share = std::min(1.0, world_.step_s() / options_.stop_window_s);
    double felt_n = 0;
    const int steps = Steps(MinimumJerkSeconds(gripper_.approach_m, options_.approach_mps));
    for (int i = 1; i <= steps; ++i) {
      const double left = 1 - MinimumJerk(static_cast<double>(i) / steps);
      hand_->MoveTo(X_WG_ * Translation({0, 0, -left * gripper_.approach_m}));
      Step();
      felt_n += share * (hand_->Load().stiff_n - felt_n);
      if (felt_n > options_.stop_force_n || hand_->yielded_m() > options_.stop_yield_m) {
        return false;
      }
    }
    return true;
  }

  // False when the fingers met each other, or a cup did not seal.
  bool CloseOnPart() {
    hand_->Close();
    const int window = Steps(kStallWindow_s);
    const double travel_s = 0.5 * opening_m_ / gripper_.hand.close_speed_mps;
    const int most = Steps(travel_s + options_.close_s);
    double last = hand_->opening_m();
    for (int i = 1; i <= most; ++i) {
      hand_->MoveTo(X_WG_);
      Step();
      if (i % window != 0) continue;
      const double speed = std::abs(last - hand_->opening_m()) / (window * world_.step_s());
      last = hand_->opening_m();
      if (i > window && speed < options_.stalled_mps) break;
    }
    return hand_->Holds();
  }

  void MarkLiftStart() {
    for (int i = 0; i < world_.part_count(); ++i) X_WO_lift_.push_back(world_.X_WO(i));
    X_WG_lift_ = hand_->X_WG();
    const double rim = scene_.bin.inner_size_m.z();
    lift_m_ = std::max(options_.lift_m, rim + reference_diameter_m_ - X_WG_.translation().z());
  }

  void Lift(GraspOutcome& outcome) {
    const int steps = Steps(options_.lift_s);
    const double retreat_m = std::min(options_.retreat_m, lift_m_);
    bool is_back = false;
    for (int i = 1; i <= steps; ++i) {
      const double height_m = lift_m_ * MinimumJerk(static_cast<double>(i) / steps);
      hand_->MoveTo(Raised(height_m));
      Step();
      if (is_back || height_m < retreat_m) continue;
      is_back = true;
      outcome.retreat_contact = !world_.PartsTouchingHand().empty();
      const double most_m = MechanismOf(gripper_).most_open_m(gripper_);
      outcome.retreat_opening = most_m > 0 ? hand_->opening_m() / most_m : hand_->Holds();
    }
    for (int i = 0; i < world_.part_count(); ++i) {
      if (!is_static_[i]) outcome.lift_height_m = std::max(outcome.lift_height_m, Rise(i));
    }
  }

  void Hold(GraspOutcome& outcome) {
    const int steps = Steps(options_.hold_s), counted = std::max(1, steps / 2);
    for (int i = 0; i < steps; ++i) {
      hand_->MoveTo(Raised(lift_m_));
      Step();
      if (i < steps - counted) continue;
      const HandLoad load = hand_->Load();
      outcome.contact_force_n += load.force_n / counted;
      outcome.contact_torque_nm += load.torque_nm / counted;
    }
  }

  // A sine that swells over its first period, since a kinematic palm must not jump to full speed.
  void Shake() {
    const int steps = Steps(options_.shake_s);
    for (int i = 1; i <= steps; ++i) {
      const double periods = i * world_.step_s() * options_.shake_hz;
      const double swing = std::min(1.0, periods) * std::sin(2 * std::numbers::pi * periods);
      hand_->MoveTo(Translation(options_.shake_m * swing * kShakeDirection_W) * Raised(lift_m_));
      Step();
    }
  }

  // Of a part's centre since the start of the lift.
  double Rise(int part) const {
    return Center(part, world_.X_WO(part)).z() - Center(part, X_WO_lift_[part]).z();
  }

  // How far a part's centre has moved in the hand since the start of the lift.
  double ShiftInHand_m(int part) const {
    const Vector3d now_G = hand_->X_WG().inverse() * Center(part, world_.X_WO(part));
    return (now_G - X_WG_lift_.inverse() * Center(part, X_WO_lift_[part])).norm();
  }

  // Parts that have come with the hand, by index: those that stayed behind by less than half of the
  // lift.
  std::vector<int> Held() const {
    std::vector<int> held;
    if (X_WO_lift_.empty()) return held;
    for (int i = 0; i < world_.part_count(); ++i) {
      if (!is_static_[i] && ShiftInHand_m(i) < 0.5 * lift_m_) held.push_back(i);
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
    const PosedObject& posed = scene_.objects[part];
    if (target_.instance >= 0) return posed.instance == target_.instance;
    return target_.object < 0 || posed.object == target_.object;
  }

  void RecordGrip(GraspOutcome& outcome) const {
    const int picked = PickedOf(Held());
    if (picked < 0) return;
    const Pose X_GO_lift = X_WG_lift_.inverse() * X_WO_lift_[picked];
    const Pose X_GO = hand_->X_WG().inverse() * world_.X_WO(picked);
    const Vector3d com_O = objects_[scene_.objects[picked].object]->mass.com_O;
    outcome.slip_m = (X_GO * com_O - X_GO_lift * com_O).norm();
    outcome.turn_rad = RotationAngleRad(X_GO_lift.linear(), X_GO.linear());
  }

  // Over the table, as high above its place as the hand was lifted.
  void Carry(int picked) {
    const PosedObject& posed = scene_.objects[picked];
    place_ = PlanPlace(scene_.bin, *objects_[posed.object], target_.X_WO.value_or(posed.X_WO),
                       X_WG_, MechanismOf(gripper_).boxes(gripper_, opening_m_), options_.place);
    world_.AddStaticBox(Translation(place_.table_W.center), place_.table_W.half_size,
                        scene_.bin.friction);
    Move(Translation({0, 0, lift_m_}) * place_.X_WG, options_.carry_mps);
  }

  void SetDown(int picked, GraspOutcome& outcome) {
    Move(place_.X_WG, options_.lower_mps);
    Withdraw();
    const ObjectModel& model = *objects_[scene_.objects[picked].object];
    const PlaceError error = PlaceErrorOf(model, place_.X_WO, world_.X_WO(picked));
    outcome.set_down = true;
    outcome.place_error_m = error.distance_m;
    outcome.place_turn_rad = error.turn_rad;
  }

  Loss JudgeHeld(GraspOutcome& outcome) const {
    outcome.parts_lifted = static_cast<int>(carried_.size());
    if (carried_.empty()) return Loss::kDropped;
    const int picked = PickedOf(carried_);
    outcome.picked_instance = scene_.objects[picked].instance;
    outcome.is_target = IsTarget(picked);
    if (carried_.size() > 1) return Loss::kTookTwo;
    return outcome.is_target ? Loss::kNone : Loss::kWrongPart;
  }

  // Opens, backs off along the approach and lets the parts come to rest.
  void Withdraw() {
    hand_->HoldOpening(opening_m_);
    // First the fingers: a part between them must not be dragged along.
    const double opening_s =
        0.5 * (opening_m_ - hand_->opening_m()) / gripper_.hand.close_speed_mps;
    for (int i = 0; i < Steps(opening_s); ++i) {
      hand_->MoveTo(hand_->X_WG());
      Step();
    }
    Move(hand_->X_WG() * Translation({0, 0, -gripper_.approach_m}), options_.approach_mps);
    for (int i = 0; i < Steps(options_.settle_s) && !world_.AllAsleep(); ++i) Step();
  }

  // By the rule that decides. What the other rules count as lost may be a success by it, and what
  // is in the hand may yet fail it where it was set down: that counts as dropped.
  void Judge(GraspOutcome& outcome) const {
    if (outcome.loss == Loss::kPhysicsFailed) return;
    outcome.verdicts = JudgeByAllRules(outcome, options_.rules);
    outcome.success = outcome.verdicts[static_cast<int>(options_.rule)];
    if (outcome.success) outcome.loss = Loss::kNone;
    if (!outcome.success && outcome.loss == Loss::kNone) outcome.loss = Loss::kDropped;
  }

  bool InsideBin(const Vector3d& center) const {
    const Vector3d half = 0.5 * scene_.bin.inner_size_m;
    return std::abs(center.x()) < half.x() && std::abs(center.y()) < half.y() && center.z() > 0;
  }

  void Conclude(ExecuteResult& result) const {
    result.after.bin = scene_.bin;
    if (result.outcome.loss == Loss::kPhysicsFailed) {
      result.after = scene_;
      return;
    }
    for (int i = 0; i < world_.part_count(); ++i) {
      if (std::find(carried_.begin(), carried_.end(), i) != carried_.end()) continue;
      PosedObject part = scene_.objects[i];
      const Vector3d before = Center(i, part.X_WO);
      if (!is_static_[i]) part.X_WO = world_.X_WO(i);
      const Vector3d center = Center(i, part.X_WO);
      const bool is_target = part.instance == target_.instance;
      result.outcome.disturbed += !is_target && (center - before).norm() > options_.disturbed_m;
      if (InsideBin(center)) result.after.objects.push_back(part);
    }
  }

  const Scene& scene_;
  const ObjectSet& objects_;
  const GripperSpec& gripper_;
  const GraspTarget target_;
  const ExecuteOptions& options_;
  const Pose X_WG_;
  PhysicsWorld world_;
  Hand* hand_ = nullptr;
  double opening_m_ = 0;
  double lift_m_ = 0;
  double reference_diameter_m_ = 0;
  std::vector<bool> is_static_;
  std::vector<bool> is_lost_;  // fell past the floor and was taken out
  std::vector<int> carried_;   // parts in the hand at the end, by index
  PlacePlan place_;
  // At the start of the lift; empty before.
  std::vector<Pose> X_WO_lift_;
  Pose X_WG_lift_ = Pose::Identity();
};

}  // namespace

ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const GripperSpec& gripper, const GraspTarget& target,
                           const ExecuteOptions& options) {
  return Attempt(scene, objects, grasp, gripper, target, options).Run();
}

}  // namespace pickbed
