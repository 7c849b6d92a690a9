#pragma once

// Stirs a bin in which no grasp is found: the closed hand pushes through the clutter. Real cells
// use this as a last resort to free instances that lean on each other or rest at a wall.
//
//     |    +--+ from             |     The hand points straight down. It descends at one end of its
//     |    |  |  ------>    to   |     path, moves along the path, and rises. A sweep ends near
//     |..../\.v.....>.......^....|     the walls, a drag inside. grasp/plan/plan_stir.h plans both.
//     |___/__\___________________|

#include "grasp/execute/execute.h"

namespace pickbed::grasp {

// Motion of a stir.
struct StirOptions {
  double speed_mps = 0.15;  // peak speed
  double settle_s = 3;      // maximum time until all instances sleep again
  void Visit(SettingsVisitor& v);
};

// Path of the hand in the bin.
struct StirPath {
  Pose X_WG_from = Pose::Identity();
  Pose X_WG_to = Pose::Identity();
  double rise_m = 0;  // the hand descends from this height above the path and rises to it
};

// Stirs the bin in physics. All instances can move. The outcome has the failure kStirred, and the
// number of instances that moved; or kPhysicsFailed, and the scene is unchanged. Instances that
// left the bin are missing in `after`. Equal inputs give identical bytes. Throws InputError for a
// path that is not finite.
ExecuteResult StirBin(const Scene& scene, const ObjectSet& objects, const Gripper& gripper,
                      const StirPath& path, const StirOptions& options = {},
                      const PhysicsOptions& physics = ExecuteOptions().physics,
                      const MotionListener& on_step = {});

}  // namespace pickbed::grasp
