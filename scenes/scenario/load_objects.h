#pragma once

// Loads the objects of a scenario and checks that they fit into its bin.

#include <functional>

#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::scenes {

// Called after each object of several, with the numbers of finished and of all objects.
using ObjectProgress = std::function<void(int done, int total)>;

// Loads each object. A sampled shape that is not cached takes 0.03 to 1 s. Throws InputError when
// an object is unknown, broken or larger than the bin, when there are fewer wanted instances than
// `draw`, or when, without `fill`, the volume of all instances of a bin may exceed the volume of a
// heap in the bin.
ObjectSet LoadObjects(const ScenarioSpec& spec, const ObjectCatalog& catalog,
                      const ObjectProgress& on_object = {});

}  // namespace pickbed::scenes
