#pragma once

// Loads the objects of a scenario and checks that they fit into its bin.

#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::scenes {

// Loads each object. Throws InputError when an object is unknown, broken or larger than the bin,
// when there are fewer wanted instances than `draw`, or when, without `fill`, the volume of all
// instances of a bin may exceed the volume of a heap in the bin.
ObjectSet LoadObjects(const ScenarioSpec& spec, const ObjectCatalog& catalog);

}  // namespace pickbed::scenes
