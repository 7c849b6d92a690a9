#pragma once

// The bin of a snapshot in physics, about one grasp: parts that neither the target nor the hand can
// move are static.

#include <vector>

#include "scenes/scene.h"
#include "scenes/settings.h"
#include "sim/physics_world.h"

namespace pickbed {

struct AttemptWorldOptions {
  double near_m = 0.02;       // parts beyond the target's diameter plus this are static
  bool all_active = false;    // all parts move and start awake: slow, to compare with
  double lost_below_m = 0.5;  // parts this far under the bin's floor have left the world
  void Visit(SettingsVisitor& v);
};

class AttemptWorld {
 public:
  // `instance` is the target's, -1 = the part nearest to the grasp. Keeps references to scene and
  // objects.
  AttemptWorld(const Scene& scene, const ObjectSet& objects, const Eigen::Vector3d& grasp_W,
               int instance, const AttemptWorldOptions& options, const PhysicsOptions& physics);

  const Scene& snapshot() const { return scene_; }
  PhysicsWorld& physics() { return physics_; }
  const PhysicsWorld& physics() const { return physics_; }
  void Step();
  int Steps(double seconds) const;  // as many as take this long

  int part_count() const { return physics_.part_count(); }
  bool IsStatic(int part) const { return is_static_[part]; }
  const PosedObject& Posed(int part) const { return scene_.objects[part]; }  // in the snapshot
  const ObjectModel& ModelOf(int part) const { return *objects_[scene_.objects[part].object]; }
  Eigen::Vector3d Center(int part, const Pose& X_WO) const;  // of mass
  // Of the part that the grasp is about, 0 = there is none.
  double reference_diameter_m() const { return reference_diameter_m_; }

  // The snapshot with every part where it is now, but without those of `gone`, by index, and those
  // outside the bin.
  Scene Remaining(const std::vector<int>& gone) const;
  // Parts that have moved further than this, but for those of `gone` and this instance.
  int Displaced(double distance_m, const std::vector<int>& gone, int instance) const;

 private:
  int ReferencePart(const Eigen::Vector3d& grasp_W, int instance) const;
  Pose X_WO_now(int part) const;

  const Scene& scene_;
  const ObjectSet& objects_;
  const double lost_below_m_;
  PhysicsWorld physics_;
  std::vector<bool> is_static_;
  std::vector<bool> is_lost_;  // fell past the floor and was taken out
  double reference_diameter_m_ = 0;
};

}  // namespace pickbed
