#pragma once

// Solid parts cannot share space.

#include "perception/model_points.h"
#include "scenes/pose.h"

namespace pickbed {

// How deep the surface of either part lies inside the other one, m: over the model points of both,
// so that a part smaller than their spacing may pass. 0 = apart. Poses are in one frame.
double PenetrationDepth(const ModelPoints& a, const Pose& X_Ca, const ModelPoints& b,
                        const Pose& X_Cb);

}  // namespace pickbed
