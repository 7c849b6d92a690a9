#pragma once

// Clusters thousands of raw pose hypotheses to some hundreds of distinct ones.

#include <vector>

#include "perception/model/pose_distance.h"
#include "perception/voting/vote_density.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// An unrefined pose with its quick score.
struct RawHypothesis {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  float quick_score = 0;  // QuickScore, higher is better
  float votes = 1;        // number of raw hypotheses that agree with it
  int patch = kNoPatch;   // patch that voted for it
};

// Greedy clustering in order of decreasing quick score; equal scores keep the input order. A
// hypothesis within `radius` (PoseDistance, in diameters) of kept ones is merged into the best of
// them, and its votes are added. `distances` is by object index. Returns at most `max_kept`
// hypotheses, best first.
std::vector<RawHypothesis> ClusterVotes(std::vector<RawHypothesis> raw,
                                        const std::vector<PoseDistance>& distances, double radius,
                                        int max_kept);

}  // namespace pickbed::perception
