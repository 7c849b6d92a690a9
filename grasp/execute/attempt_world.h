#pragma once

// Physics world of one grasp attempt, built from a snapshot of the bin. Instances that neither the
// target nor the hand can move are static.

#include <span>
#include <vector>

#include "grasp/layer.h"
#include "scenes/base/ids.h"
#include "scenes/base/settings.h"
#include "scenes/scene.h"
#include "sim/physics/physics_world.h"

namespace pickbed::grasp {

// Options of AttemptWorld.
struct AttemptWorldOptions {
  // An instance is static if its box is further than this from the box of the target and from the
  // boxes of the hand, in the grasp pose and while the lift moves aside.
  double near_m = 0.02;
  bool all_active = false;    // all instances are dynamic and awake: slow, as a reference
  double lost_below_m = 0.5;  // instances this far under the floor are removed
  void Visit(SettingsVisitor& v);
};

// Physics world of one attempt.
class AttemptWorld {
 public:
  // `instance`: the target, -1 = the instance nearest to the origin of the hand. `hand_G`: boxes of
  // the hand in its grasp pose X_WG. `lift_aside_m`: Grasp::lift_aside_m. Keeps references to scene
  // and objects. A `position` is an index into scene.objects.
  AttemptWorld(const Scene& scene, const ObjectSet& objects, const Pose& X_WG,
               std::span<const AxisAlignedBox> hand_G, const Eigen::Vector2d& lift_aside_m,
               InstanceId instance, const AttemptWorldOptions& options,
               const PhysicsOptions& physics);

  const Scene& snapshot() const { return scene_; }
  PhysicsWorld& physics() { return physics_; }
  const PhysicsWorld& physics() const { return physics_; }
  void Step();
  int Steps(double seconds) const;  // number of steps with this duration, rounded

  int instance_count() const { return physics_.instance_count(); }
  bool IsStatic(int position) const { return is_static_[position]; }
  // Pose in the snapshot.
  const PosedObject& Posed(int position) const { return scene_.objects[position]; }
  const ObjectModel& ModelOf(int position) const {
    return *objects_[scene_.objects[position].object];
  }
  Eigen::Vector3d Center(int position, const Pose& X_WO) const;  // center of mass in W
  // Present pose. A static instance has exactly its pose of the snapshot.
  Pose PoseOf(int position) const;
  // Diameter of the target, or of the instance nearest to the grasp; 0 if the bin is empty.
  double reference_diameter_m() const { return reference_diameter_m_; }

  // Scene with the present poses, without the instances with an index in `gone` and those outside
  // the bin.
  Scene Remaining(const std::vector<int>& gone) const;
  // Number of instances that moved further than this, without those in `gone` and `instance`.
  int Displaced(double distance_m, const std::vector<int>& gone, InstanceId instance) const;

 private:
  int ReferenceInstance(const Eigen::Vector3d& grasp_W, InstanceId instance) const;

  const Scene& scene_;
  const ObjectSet& objects_;
  const double lost_below_m_;
  PhysicsWorld physics_;
  std::vector<bool> is_static_;
  std::vector<bool> is_lost_;  // fell past the floor and was removed
  double reference_diameter_m_ = 0;
};

}  // namespace pickbed::grasp
