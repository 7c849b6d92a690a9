#pragma once

// Planner without poses for parallel jaws: antipodal grasps on the observed surface. It knows the
// camera, the gripper and, if given, the bin, but no object.
//
// For each orientation of the hand, the surface becomes a height map along the approach, in which
// opposing faces are found (grasp/cloud/opposing_faces.h). The space behind the first surface is
// unknown and counts as occupied, so the hand never enters it. The idea of sweeping a hand model
// over a height map is from Domae et al., "Fast graspability evaluation on single depth maps for
// bin picking with general grippers", ICRA 2014; the contacts are rated by their friction cones as
// in ten Pas et al., "Grasp pose detection in point clouds", IJRR 2017.

#include <vector>

#include "grasp/cloud/observed_surface.h"
#include "grasp/cloud/opposing_faces.h"
#include "grasp/grippers/parallel_jaw.h"
#include "grasp/plan/planner.h"

namespace pickbed::grasp {

struct CloudAntipodalOptions {
  int angles = 24;                 // closing directions of a vertical approach, over half a turn
  int tilts = 6;                   // horizontal directions into which the approach is tilted
  int tilted_angles = 8;           // closing directions of each tilted approach
  double tilt_share = 0.25;        // share of the score that is lost at the largest tilt
  double min_score = 0.03;         // grasps with a lower score are not reported
  double bin_clearance_m = 0.002;  // between hand and bin
  double apart_m = 0.008;   // grasps nearer to a better one and within apart_rad are left out
  double apart_rad = 0.25;  // angle of the closing directions and of the approaches
  SurfaceOptions surface;
  OpposingFacesOptions faces;
  void Visit(SettingsVisitor& v);
};

class CloudAntipodal : public Planner {
 public:
  // Throws InputError if a tool is not a parallel jaw, or for options out of range.
  explicit CloudAntipodal(const PlannerSetup& setup, const CloudAntipodalOptions& options = {});

  // Causes of rejection: "no room for the fingers", "palm meets an instance", "two instances
  // between the fingers", "faces outside the friction cone", "too little to hold", "score too
  // low", "bin wall" and "outranked".
  PlanResult Plan(const PlannerInput& input) override;

 private:
  const PlannerSpec spec_;
  const CloudAntipodalOptions options_;
  std::vector<const ParallelJaw*> jaws_;
  std::vector<Eigen::Matrix3d> R_BG_;  // orientations of the hand
};

// Returns the orientations of the hand in B: straight down, and tilted by `max_tilt_rad`.
std::vector<Eigen::Matrix3d> HandOrientations(const CloudAntipodalOptions& options,
                                              double max_tilt_rad);

}  // namespace pickbed::grasp
