#pragma once

// Separating-axis test of two oriented boxes (Gottschalk et al. 1996).

#include "grasp/layer.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"

namespace pickbed::grasp {

// Returns whether two boxes do not overlap: one along the axes of W, one along the axes of G at
// X_WG. W may be any frame.
bool BoxesApart(const AxisAlignedBox& box_W, const AxisAlignedBox& box_G, const Pose& X_WG);

}  // namespace pickbed::grasp
