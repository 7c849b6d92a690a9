#pragma once

// How a part comes to lie on a plane when it is dropped.

#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

struct RestingPose {
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  // the world's up in the part's frame
  Pose X_WO = Pose::Identity();  // standing so on the plane z = 0, the origin of O above W's
  double probability = 0;        // share of the drops
};

// Drops `drops` copies in random orientations side by side onto a plane and groups how they came to
// rest; ways that the part's symmetries make one are one. Most frequent first; parts that still
// moved at the end are left out, so that probabilities may sum to less than 1. The same for the
// same `seed`. The model must have convex pieces (std::logic_error).
std::vector<RestingPose> FindRestingPoses(const ObjectModel& model, int drops = 100,
                                          uint64_t seed = 0);

// The same parts with resting_O filled in where it is empty, from the cache or found now.
ObjectSet WithRestingDirections(const ObjectSet& objects);

}  // namespace pickbed
