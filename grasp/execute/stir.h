#pragma once

// Stirs a bin in which no grasp is found: the closed hand pushes through the clutter. Real cells
// use this as a last resort to free instances that lean on each other or rest at a wall.
//
//     |    +--+ start            |     The hand points straight down. It descends at one end of its
//     |    |  |  ------>   end   |     path, moves along the path, and rises. The path ends near
//     the
//     |..../\.v.....>.......^....|     walls.
//     |___/__\___________________|

#include "grasp/execute/execute.h"

namespace pickbed::grasp {

// Path and speed of a stir.
struct StirOptions {
  // Depth of the tips below the height that a quarter of the instances exceed. The floor limits it.
  double depth_m = 0.03;
  double floor_m = 0.005;   // between the tips and the floor
  double wall_m = 0.01;     // between the hand and the walls
  double speed_mps = 0.15;  // peak speed
  double settle_s = 3;      // maximum time until all instances sleep again
  void Visit(SettingsVisitor& v);
};

// Pose of the hand at the start and at the end of the path. `number`: of the stir in its trial.
// Directions alternate between the length and the width of the bin, where the path meets the
// largest number of instances, and its diagonals; then the same with the opposite senses.
struct StirPath {
  Pose X_WG_from = Pose::Identity();
  Pose X_WG_to = Pose::Identity();
};
StirPath PlanStir(const Scene& scene, const ObjectSet& objects, const Gripper& gripper, int number,
                  const StirOptions& options = {});

// Stirs the bin in physics. All instances can move. The outcome has the failure kStirred, and the
// number of instances that moved; or kPhysicsFailed, and the scene is unchanged. Instances that
// left the bin are missing in `after`. Equal inputs give identical bytes.
ExecuteResult StirBin(const Scene& scene, const ObjectSet& objects, const Gripper& gripper,
                      int number, const StirOptions& options = {},
                      const PhysicsOptions& physics = ExecuteOptions().physics,
                      const MotionListener& on_step = {});

}  // namespace pickbed::grasp
