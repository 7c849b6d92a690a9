#pragma once

// Plans the path of a stir (grasp/execute/stir.h) from observed points, never from ground truth.

#include <span>

#include "grasp/execute/stir.h"
#include "scenes/bin/bin.h"

namespace pickbed::grasp {

// Distances of a stir.
struct PlanStirOptions {
  // Depth of the tips below the height that a quarter of the points exceed. A single instance that
  // leans high at a wall does not make the hand pass above all others. The floor limits the depth.
  double depth_m = 0.03;
  double floor_m = 0.005;     // between the tips and the floor
  double wall_m = 0.01;       // between the hand and the walls
  double voxel_m = 0.005;     // voxel size to which the cloud is thinned
  double bin_band_m = 0.006;  // points this close to floor and walls belong to the bin
  // Below this covered share of the floor, only a few instances are left, mostly at walls, where no
  // path meets them. Then the hand drags.
  double drag_share = 0.15;
  double drag_m = 0.12;          // length of a drag
  double press_m = 0.004;        // of the tips into the point; the fingers yield at their limit
  double drag_wall_m = 0.003;    // between the dragging hand and the walls
  double drag_side_m = 0.025;    // a hand whose axis stays farther from the walls does not drag
  double drag_near_m = 0.06;     // a drag is away from the walls within this distance
  double drag_radius_m = 0.015;  // the highest point within this distance of a place is pressed
  int drag_points = 5;           // within this radius of a point that is pressed; fewer are noise
  double drag_apart_m = 0.04;    // between the places of two drags
  void Visit(SettingsVisitor& v);
};

// Plans the pose of the closed hand at the start and at the end of a straight path.
// - bin: the frame of its floor is W
// - cloud_W: observed points, with or without the bin
// - number: of the stir in its trial. Directions alternate between the length and the width of the
//   bin, where the path meets the largest number of points, and its diagonals. Then the same
//   follows with the opposite senses.
// If little of the floor is covered, and the palm passes above the walls, the fingers press on a
// point near a wall instead, and drag what is below it inward. The next numbers use other points,
// ordered by their distance from a wall. Throws InputError for options out of range.
StirPath PlanStir(const Bin& bin, std::span<const Eigen::Vector3d> cloud_W, const Gripper& gripper,
                  int number, const PlanStirOptions& options = {});

}  // namespace pickbed::grasp
