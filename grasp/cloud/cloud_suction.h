#pragma once

// Planner without poses for suction cups: places of the observed surface that are flat enough for
// the lip. It knows the camera, the gripper and, if given, the bin, but no object.
//
// A plane is fitted to the measured points under the lip. The cup seals if all of its rim is on
// measured surface of one segment and the points are near the plane:
//
//       | stem |            keeps clear of everything above the surface
//       |______|
//       \      /  bellows
//     ___\____/___  measured surface: all around the rim, without an edge inside it
//
// The space behind the first surface is unknown and counts as occupied.

#include <vector>

#include "grasp/cloud/observed_surface.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/plan/planner.h"

namespace pickbed::grasp {

struct CloudSuctionOptions {
  double spacing_m = 0.006;  // between the places that are tested
  int rim_sectors = 16;      // each needs measured surface near the rim
  double rim_inside = 0.75;  // inner and outer limit of "near the rim", shares of the lip's radius
  double rim_outside = 1.2;
  double even_share = 0.9;    // share of the points that must be within the tolerance of the lip
  double lever_m = 0.03;      // distance from the center of the segment that halves the score
  double tilt_share = 0.25;   // share of the score that is lost at the largest tilt
  double height_share = 0.3;  // share of the score that the lowest segment loses
  double min_score = 0.05;    // grasps with a lower score are not reported
  double bin_clearance_m = 0.002;  // between hand and bin
  double column_m = 0.010;         // cell size of the floor-plan grid of the points
  double apart_m = 0.012;          // grasps nearer to a better one are left out
  SurfaceOptions surface;
  void Visit(SettingsVisitor& v);
};

class CloudSuction : public Planner {
 public:
  // Throws InputError if a tool is not a suction cup, or for options out of range.
  explicit CloudSuction(const PlannerSetup& setup, const CloudSuctionOptions& options = {});

  // Causes of rejection: "lip over an edge", "uneven under the lip", "tilt", "score too low", "stem
  // or palm meets an instance", "bin wall" and "outranked".
  PlanResult Plan(const PlannerInput& input) override;

 private:
  const PlannerSpec spec_;
  const CloudSuctionOptions options_;
  std::vector<const SuctionCup*> cups_;
};

}  // namespace pickbed::grasp
