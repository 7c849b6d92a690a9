#pragma once

// Picks that cannot disturb each other, so that one image serves several of them.
//
// A pick moves its object, may move what is near it, and sweeps the hand through the bin. Two picks
// are independent if both of these hold:
// 1. Seen from above, the centers of mass of their objects are at least half of each diameter plus
//    `apart_m` plus the sideways shifts of both lifts apart. So each object is outside the space
//    through which the other object is lifted. A pick moves few instances that are further away.
// 2. Each hand keeps its clearance from the surface of the other object: on its approach, when it
//    closes, and while it is lifted.

#include <span>
#include <vector>

#include "grasp/plan/plan.h"

namespace pickbed::grasp {

// Distances of independent picks.
struct ImagePicksOptions {
  double apart_m = 0.02;     // between the objects, beyond half of each diameter
  double spacing_m = 0.004;  // of the points on an object's surface
  double lift_step_m = 0.005;
  void Visit(SettingsVisitor& v);
};

// The picks that use one image.
class ImagePicks {
 public:
  // `objects` must outlive this object. Throws InputError for options out of range.
  explicit ImagePicks(const ObjectSet& objects, const ImagePicksOptions& options = {});

  // Adds a pick of the object at `pose` with `grasp` in the world.
  void Add(const Grasp& grasp, const EstimatedPose& pose, const Gripper& gripper);
  bool empty() const { return picks_.empty(); }
  size_t size() const { return picks_.size(); }

  // Returns whether an object at `pose` is far enough from the objects of all added picks (rule 1).
  bool IsApart(const EstimatedPose& pose) const;
  // Returns whether a pick is independent of all added ones (rules 1 and 2).
  bool IsIndependent(const Grasp& grasp, const EstimatedPose& pose, const Gripper& gripper) const;

 private:
  struct Pick {
    Eigen::Vector3d center_W;   // center of mass
    double radius_m;            // half of the diameter, and the shift of the lift
    Eigen::Matrix3Xd points_W;  // on the surface
    Pose X_WG;
    Eigen::Vector2d lift_aside_m;
    std::vector<AxisAlignedBox> hand_G;   // the open hand
    std::vector<AxisAlignedBox> sweep_G;  // its approach
    double clearance_m;
  };

  const Eigen::Matrix3Xd& PointsOf(ObjectId object) const;
  Pick MakePick(const Grasp& grasp, const EstimatedPose& pose, const Gripper& gripper) const;
  bool AreApart(const Pick& pick, const Eigen::Vector3d& center_W, double radius_m) const;
  bool HandKeepsOff(const Pick& pick, const Eigen::Matrix3Xd& points_W) const;

  const ObjectSet& objects_;
  const ImagePicksOptions options_;
  std::vector<Pick> picks_;
  mutable std::vector<Eigen::Matrix3Xd> points_O_;  // by object; empty until they are needed
};

}  // namespace pickbed::grasp
