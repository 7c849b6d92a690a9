#pragma once

// Antipodal grasp candidates on a part's mesh: pairs of surface points whose connecting line lies
// in both friction cones (Nguyen 1988), with approach directions around the closing axis.

#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/object_model.h"
#include "scenes/random.h"

namespace pickbed {

struct AntipodalOptions {
  int candidates = 400;     // wanted
  int max_samples = 20000;  // surface points tried at most
  int approaches = 12;      // around the closing axis
  double cone_share = 0.8;  // of the friction cone's half angle that is used
};

// Empty when the part has no antipodal pair that fits the stroke: a result, not an error.
std::vector<GraspCandidate> AntipodalGrasps(const ObjectModel& model, const GripperSpec& gripper,
                                            Rng& rng, const AntipodalOptions& options = {});

// The same from the cache, keyed by mesh hash, gripper and options; made and stored when missing.
std::vector<GraspCandidate> CachedAntipodalGrasps(const ObjectModel& model,
                                                  const GripperSpec& gripper,
                                                  const AntipodalOptions& options = {});

}  // namespace pickbed
