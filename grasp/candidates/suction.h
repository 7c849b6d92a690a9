#pragma once

// Suction grasp candidates: surface points at which the whole lip seals (sim/hands/suction_seal.h),
// approached along the surface normal.
//
// The quality, 0..1, is a product of three factors: flatness under the lip, tilt of the lip plane
// to the approach, and the moment of the weight about the axis of the lip relative to the moment
// that breaks the seal.

#include <vector>

#include "grasp/candidates/pad_contact.h"
#include "grasp/candidates/robustness.h"
#include "grasp/grasp.h"
#include "sim/hands/suction_hand.h"

namespace pickbed::grasp {

// Options of suction candidates.
struct SuctionOptions {
  int candidates = 500;            // maximum number of candidates
  int max_samples = 3000;          // sampled surface points
  double point_spacing_m = 0.002;  // of the surface points for tests of stem and palm
  int min_points = 2000;           // minimum number of these points
  int max_points = 8000;           // maximum number of these points
  double own_margin_m = 0.0005;    // between the stem and the object
  double max_tilt_rad = 0.35;  // tilt of the lip plane to the approach at which the quality is 0
  double spacing_m = 0.004;    // candidates closer than both spacings are duplicates
  double spacing_rad = 0.25;
  void Visit(SettingsVisitor& v);
};

// Samples suction candidates of an object, in O; epsilon and robust are set. Returns an empty list
// if the lip seals nowhere; this is not an error.
std::vector<GraspCandidate> SuctionGrasps(const ObjectModel& model, const CupSpec& cup, Rng& rng,
                                          const SuctionOptions& options,
                                          const RobustOptions& robust);

// Wrenches that a sealed cup can exert on the object, in the units of
// grasp/candidates/robustness.h. The model is the ring contact of sim/hands/suction_hand.h with 8
// points. `compression_m`: distance of the object behind the uncompressed lip.
WrenchSet CupWrenches(const ObjectModel& model, const CupSpec& cup, const Pose& X_OG,
                      double compression_m, double friction_factor, int cone_edges);

}  // namespace pickbed::grasp
