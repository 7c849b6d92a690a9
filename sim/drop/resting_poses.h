#pragma once

// Poses in which a dropped object comes to rest on a plane.

#include <vector>

#include "scenes/objects/object_model.h"
#include "sim/layer.h"

namespace pickbed::sim {

// A stable pose on a plane.
struct RestingPose {
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  // world z in the object frame
  Pose X_WO = Pose::Identity();  // on the plane z = 0, origin of O above the origin of W
  double probability = 0;        // share of the drops
};

// Drops `drops` copies in random orientations side by side onto a plane and groups their final
// poses. Poses that are equal by the object's symmetries form one group. Returns the most frequent
// first. Copies that still move at the end are left out, so probabilities may sum to less than 1.
// The same `seed` gives the same result. Throws std::logic_error if the model has no convex pieces.
std::vector<RestingPose> FindRestingPoses(const ObjectModel& model, int drops = 100,
                                          uint64_t seed = 0);

// Returns the objects with an empty resting_O filled in, from the disk cache or by
// FindRestingPoses().
ObjectSet WithRestingDirections(const ObjectSet& objects);

}  // namespace pickbed::sim
