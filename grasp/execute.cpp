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

class Attempt {
 public:
  Attempt(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
          const GripperSpec& gripper, int target_instance, const ExecuteOptions& options)
      : scene_(scene),
        objects_(objects),
        gripper_(gripper),
        target_instance_(target_instance),
        options_(options),
        X_WG_(grasp.X_WG),
        world_(options.physics) {
    const auto opening = MechanismOf(gripper).approach_opening_m(gripper, grasp.width_m);
    opening_m_ = opening.value_or(gripper.hand.stroke_m);
    AddParts();
    // A hand starts as open as its stroke lets it: its sliders' end stop is where it shall start.
    HandSpec hand = gripper.hand;
    hand.stroke_m = opening_m_;
    hand_ = &world_.AddHand(hand, X_WG_ * Translation({0, 0, -gripper.approach_m}));
    hand_->HoldOpening(opening_m_);
  }

  ExecuteResult Run() {
    ExecuteResult result;
    GraspOutcome& outcome = result.outcome;
    outcome.loss = Try(outcome);
    if (outcome.loss != Loss::kPhysicsFailed && Held().empty()) Withdraw();
    if (world_.BlewUp()) outcome.loss = Loss::kPhysicsFailed;
    outcome.success = outcome.loss == Loss::kNone;
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
      if (scene_.objects[i].instance == target_instance_) return static_cast<int>(i);
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
    }
    reference_diameter_m_ = reference < 0 ? 0 : Diameter(reference);
  }

  int Steps(double seconds) const {
    return static_cast<int>(std::lround(seconds / world_.step_s()));
  }

  Pose Raised(double height_m) const { return Translation({0, 0, height_m}) * X_WG_; }

  Loss Try(GraspOutcome& outcome) {
    if (!Approach()) return Loss::kCollision;
    if (!CloseOnPart()) return Loss::kClosedOnNothing;
    MarkLiftStart();
    outcome.final_opening_m = hand_->opening_m();
    Lift();
    if (world_.BlewUp()) return Loss::kPhysicsFailed;
    if (Held().empty()) return Loss::kSlipped;
    Hold();
    Shake();
    if (world_.BlewUp()) return Loss::kPhysicsFailed;
    outcome.final_opening_m = hand_->opening_m();
    return JudgeHeld(outcome);
  }

  // False when a finger meets more than the stopping force on the way.
  bool Approach() {
    const int steps = Steps(options_.approach_s);
    for (int i = 1; i <= steps; ++i) {
      const double left = 1 - MinimumJerk(static_cast<double>(i) / steps);
      hand_->MoveTo(X_WG_ * Translation({0, 0, -left * gripper_.approach_m}));
      world_.Step();
      const auto forces = hand_->ContactForces_n();
      if (std::max(forces[0], forces[1]) > options_.stop_force_n) return false;
    }
    return true;
  }

  // False when the fingers met each other.
  bool CloseOnPart() {
    hand_->Close();
    const int window = Steps(kStallWindow_s);
    const double travel_s = 0.5 * opening_m_ / gripper_.hand.close_speed_mps;
    const int most = Steps(travel_s + options_.close_s);
    double last = hand_->opening_m();
    for (int i = 1; i <= most; ++i) {
      hand_->MoveTo(X_WG_);
      world_.Step();
      if (i % window != 0) continue;
      const double speed = std::abs(last - hand_->opening_m()) / (window * world_.step_s());
      last = hand_->opening_m();
      if (i > window && speed < options_.stalled_mps) break;
    }
    return !world_.PartsTouchingHand().empty();
  }

  void MarkLiftStart() {
    for (int i = 0; i < world_.part_count(); ++i) X_WO_lift_.push_back(world_.X_WO(i));
    X_WG_lift_ = hand_->X_WG();
    const double rim = scene_.bin.inner_size_m.z();
    lift_m_ = std::max(options_.lift_m, rim + reference_diameter_m_ - X_WG_.translation().z());
  }

  void Lift() {
    const int steps = Steps(options_.lift_s);
    for (int i = 1; i <= steps; ++i) {
      hand_->MoveTo(Raised(lift_m_ * MinimumJerk(static_cast<double>(i) / steps)));
      world_.Step();
    }
  }

  void Hold() {
    for (int i = 0; i < Steps(options_.hold_s); ++i) {
      hand_->MoveTo(Raised(lift_m_));
      world_.Step();
    }
  }

  // A sine that swells over its first period, since a kinematic palm must not jump to full speed.
  void Shake() {
    const int steps = Steps(options_.shake_s);
    for (int i = 1; i <= steps; ++i) {
      const double periods = i * world_.step_s() * options_.shake_hz;
      const double swing = std::min(1.0, periods) * std::sin(2 * std::numbers::pi * periods);
      hand_->MoveTo(Translation(options_.shake_m * swing * kShakeDirection_W) * Raised(lift_m_));
      world_.Step();
    }
  }

  // Parts that have risen with the hand by more than half of the lift, by index.
  std::vector<int> Held() const {
    std::vector<int> held;
    if (X_WO_lift_.empty()) return held;
    for (int i = 0; i < world_.part_count(); ++i) {
      if (is_static_[i]) continue;
      const double rise = Center(i, world_.X_WO(i)).z() - Center(i, X_WO_lift_[i]).z();
      if (rise > 0.5 * lift_m_) held.push_back(i);
    }
    return held;
  }

  Loss JudgeHeld(GraspOutcome& outcome) const {
    const std::vector<int> held = Held();
    outcome.parts_lifted = static_cast<int>(held.size());
    if (held.empty()) return Loss::kDropped;
    int picked = held.front();
    for (const int part : held) {
      if (scene_.objects[part].instance == target_instance_) picked = part;
    }
    outcome.picked_instance = scene_.objects[picked].instance;
    const Pose X_GO_lift = X_WG_lift_.inverse() * X_WO_lift_[picked];
    const Pose X_GO = hand_->X_WG().inverse() * world_.X_WO(picked);
    const Vector3d com_O = objects_[scene_.objects[picked].object]->mass.com_O;
    outcome.slip_m = (X_GO * com_O - X_GO_lift * com_O).norm();
    outcome.turn_rad = RotationAngleRad(X_GO_lift.linear(), X_GO.linear());
    if (held.size() > 1) return Loss::kTookTwo;
    if (target_instance_ >= 0 && outcome.picked_instance != target_instance_) {
      return Loss::kWrongPart;
    }
    return Loss::kNone;
  }

  // Empty-handed: opens, backs off along the approach and lets the parts come to rest.
  void Withdraw() {
    hand_->HoldOpening(opening_m_);
    const Pose from = hand_->X_WG();
    const int steps = Steps(options_.approach_s);
    for (int i = 1; i <= steps; ++i) {
      const double done = MinimumJerk(static_cast<double>(i) / steps);
      hand_->MoveTo(from * Translation({0, 0, -done * gripper_.approach_m}));
      world_.Step();
    }
    for (int i = 0; i < Steps(options_.settle_s) && !world_.AllAsleep(); ++i) world_.Step();
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
    const std::vector<int> held = Held();
    for (int i = 0; i < world_.part_count(); ++i) {
      if (std::find(held.begin(), held.end(), i) != held.end()) continue;
      PosedObject part = scene_.objects[i];
      const Vector3d before = Center(i, part.X_WO);
      if (!is_static_[i]) part.X_WO = world_.X_WO(i);
      const Vector3d center = Center(i, part.X_WO);
      const bool is_target = part.instance == target_instance_;
      result.outcome.disturbed += !is_target && (center - before).norm() > options_.disturbed_m;
      if (InsideBin(center)) result.after.objects.push_back(part);
    }
  }

  const Scene& scene_;
  const ObjectSet& objects_;
  const GripperSpec& gripper_;
  const int target_instance_;
  const ExecuteOptions& options_;
  const Pose X_WG_;
  PhysicsWorld world_;
  Hand* hand_ = nullptr;
  double opening_m_ = 0;
  double lift_m_ = 0;
  double reference_diameter_m_ = 0;
  std::vector<bool> is_static_;
  // At the start of the lift; empty before.
  std::vector<Pose> X_WO_lift_;
  Pose X_WG_lift_ = Pose::Identity();
};

}  // namespace

ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const GripperSpec& gripper, int target_instance,
                           const ExecuteOptions& options) {
  return Attempt(scene, objects, grasp, gripper, target_instance, options).Run();
}

}  // namespace pickbed
