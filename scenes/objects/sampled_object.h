#pragma once

// The object of a sampled shape (scenes/shape_families).

#include <string>

#include "scenes/objects/object_model.h"
#include "scenes/shape_families/shape_family.h"

namespace pickbed::scenes {

// Makes the object from its mesh, density, color and friction. Its symmetries, convex pieces and
// resting poses are left out.
ObjectModel SampledObject(const std::string& name, const SampledShape& shape);

}  // namespace pickbed::scenes
