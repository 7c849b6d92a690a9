#pragma once

// Keys of object.yaml, for help and the generated reference. Objects are read by
// scenes/objects/object_catalog.h, which shows an example of the file.

#include "scenes/base/settings.h"

namespace pickbed::scenes {

inline constexpr double kMaxObjectMass_kg = 100;

// Visits all keys of object.yaml with their default values, ranges and help. The lists
// (symmetries.discrete, symmetries.continuous and resting_poses) are empty. A visitor that resizes
// a list sees the keys of its items.
void VisitObjectSettings(SettingsVisitor& v);

}  // namespace pickbed::scenes
