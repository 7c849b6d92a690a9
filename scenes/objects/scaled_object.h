#pragma once

// An object of another size than its model.

#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// Returns the object, enlarged by `factor` (> 0) about the origin of O. The density is kept: the
// mass grows with the third power of the factor and the inertia with the fifth. A factor of 1
// changes nothing.
ObjectModel ScaledObject(const ObjectModel& model, double factor);

}  // namespace pickbed::scenes
