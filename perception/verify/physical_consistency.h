#pragma once

// Physical consistency of a pose: bins and instances are solid, and an object at rest is supported.
// If two poses look the same to the camera, the one that penetrates the floor is wrong.

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"
#include "scenes/geometry/pose.h"

namespace pickbed::perception {

// Position of an object relative to the bin.
struct Containment {
  float outside_m = 0;  // maximum penetration of floor or walls
  float height_m = 0;   // of its lowest point over the floor; negative if it penetrates the floor
  bool has_floor = false;  // false: the background is unknown, the other fields are 0
};

// Compares the model points with the background planes of the cloud. Does not allocate.
Containment MeasureContainment(const OrganizedCloud& cloud, const ModelPoints& model,
                               const Pose& X_CO);

// Returns the maximum depth of the surface of either object inside the other, in metres; 0 if they
// are apart. It is evaluated at the model points of both, so objects smaller than the point spacing
// may be missed. Both poses are in the same frame.
double PenetrationDepth(const ModelPoints& a, const Pose& X_Ca, const ModelPoints& b,
                        const Pose& X_Cb);

}  // namespace pickbed::perception
