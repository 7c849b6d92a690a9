#pragma once

// First part of an executed grasp: the hand approaches, closes, lifts, holds and shakes.

#include <vector>

#include "grasp/execute/execute.h"
#include "sim/hands/hand.h"

namespace pickbed::grasp {

// A hand in the world of one attempt. Keeps references to all arguments of the constructor but
// `grasp` and `target`. A `position` is an index into scene.objects.
class PickUp {
 public:
  PickUp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp, const Gripper& gripper,
         const GraspTarget& target, const ExecuteOptions& options, const MotionListener& on_step);

  // Approaches, lifts, holds and shakes, and fills in what was measured. kNone does not say that an
  // instance is in the hand.
  FailureReason Run(GraspOutcome& outcome);

  // Makes one step, with the hand as it is.
  void Step();
  // Makes one step towards a pose. Only the palm is driven.
  void Advance(const Pose& X_WG);
  // Moves along a straight line with minimum jerk.
  void Move(const Pose& X_WG_to, double peak_mps);
  // Start of the straight approach to a pose.
  Pose Behind(const Pose& X_WG) const { return X_WG * Translation({0, 0, -gripper_.approach_m}); }
  // Pose of the hand during hold and shake.
  Pose Lifted() const { return Raised(lift_m_); }

  // Instances that moved with the hand: they shifted in G by less than half of the lift.
  std::vector<int> Held() const;
  bool IsInHand(int position) const { return ShiftInHand_m(position) < 0.5 * lift_m_; }
  // The target if it is in the hand, else the first; -1 = none.
  int PickedOf(const std::vector<int>& held) const;
  bool IsTarget(int position) const;
  // Whether the hand touched the instance for at least half of the hold. An instance that is hooked
  // on another one may swing against the hand. Only after Run().
  bool IsGripped(int position) const { return 2 * touched_steps_[position] >= held_steps_; }
  // Fills in the motion of the picked instance in the hand since the start of the lift.
  void RecordGrip(GraspOutcome& outcome) const;

  // Reports this table to the listener from now on.
  void ShowTable(const AxisAlignedBox& table_W);

  AttemptWorld& world() { return world_; }
  const AttemptWorld& world() const { return world_; }
  Hand& hand() { return hand_; }
  const Pose& X_WG() const { return X_WG_; }                             // executed grasp
  double opening_m() const { return opening_m_; }                        // on the approach
  const std::vector<AxisAlignedBox>& boxes_G() const { return boxes_; }  // at this opening

 private:
  Eigen::Vector3d Center(int position) const {
    return world_.Center(position, world_.physics().X_WO(position));
  }
  Pose Raised(double height_m) const;
  bool IsUnderFloor() const;
  bool Approach();
  bool MoveUntilHeld(const Pose& X_WG_from, const Pose& X_WG_to, double distance_m);
  bool CloseOnInstance();
  void MarkLiftStart();
  void Lift(GraspOutcome& outcome);
  void Hold(GraspOutcome& outcome);
  void Shake();
  void WatchDrop();
  double Rise(int position) const;
  double ShiftInHand_m(int position) const;

  const Bin& bin_;
  const Gripper& gripper_;
  const GraspTarget target_;
  const ExecuteOptions& options_;
  const MotionListener& on_step_;
  int steps_ = 0;  // reported to on_step_
  const Eigen::Vector2d lift_aside_m_;
  Pose X_WG_;  // of the grasp, or where the approach of a hand that holds on contact ended
  const double opening_m_;
  const std::vector<AxisAlignedBox> boxes_;  // of the hand at opening_m_, in G
  AttemptWorld world_;
  Hand& hand_;
  std::optional<AxisAlignedBox> table_W_;
  double lift_m_ = 0;
  // By position: number of steps of the hold in which the hand touched the instance.
  std::vector<int> touched_steps_;
  int held_steps_ = 0;
  int watched_ = -1;  // position of the instance whose drop is timed, -1 = none
  int watched_steps_ = 0;
  double drop_time_s_ = -1;
  // Poses at the start of the lift; empty before.
  std::vector<Pose> X_WO_lift_;
  Pose X_WG_lift_ = Pose::Identity();
};

}  // namespace pickbed::grasp
