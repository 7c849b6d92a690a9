#pragma once

// Where a suction cup may hold a part: places whose surface closes the lip all round
// (sim/cup_seal.h), approached along their normal.
//
// Quality, 0..1, is a product of: flatness under the lip, tilt of the lip's plane to the approach,
// and lever of the part's weight about the lip's axis against the moment that breaks the cup off.

#include <vector>

#include "grasp/grasp.h"
#include "grasp/pad_contact.h"
#include "grasp/robust.h"

namespace pickbed {

struct SuctionOptions {
  int candidates = 500;            // wanted
  int max_samples = 3000;          // surface points tried
  double point_spacing_m = 0.002;  // of the surface points that stem and palm are tested on
  int min_points = 2000;           // of them, whatever the spacing
  int max_points = 8000;           //
  double own_margin_m = 0.0005;    // between the stem and the part itself
  double max_tilt_rad = 0.35;      // of the lip's plane to the approach, at which nothing is left
  double spacing_m = 0.004;        // candidates nearer than both spacings count as one
  double spacing_rad = 0.25;
  void Visit(SettingsVisitor& v);
};

// Empty when the lip seals nowhere: a result, not an error. Epsilon and robust are set.
std::vector<GraspCandidate> SuctionGrasps(const ObjectModel& model, const GripperSpec& gripper,
                                          Rng& rng, const SuctionOptions& options,
                                          const RobustOptions& robust);

// What a sealed cup can put on a part, in the units of grasp/robust.h, by the model of
// sim/cup_limit.h with the ring as 8 points. `compression_m` is where the part is.
WrenchSet CupWrenches(const ObjectModel& model, const CupSpec& cup, const Pose& X_OG,
                      double compression_m, double friction_factor, int cone_edges);

}  // namespace pickbed
