#pragma once

// What a pose says of the part beyond what is seen of it: bins and other parts are solid, and a
// part at rest stands on something. Of two poses that the camera cannot tell apart, the one that
// reaches through the floor is wrong.

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"

namespace pickbed {

struct Containment {
  float outside_m = 0;     // how far the part reaches through floor or walls
  float height_m = 0;      // of its lowest point over the floor, below 0 where it reaches through
  bool has_floor = false;  // false: neither is known
};

// Against the planes of the cloud's background. No allocation.
Containment MeasureContainment(const OrganizedCloud& cloud, const ModelPoints& model,
                               const Pose& X_CO);

}  // namespace pickbed
