#pragma once

// How full a bin is after the drop, in words.

#include <string>

#include "eval/layer.h"
#include "scenes/objects/object_model.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Returns a sentence such as "A bin of 18 l gets 96 objects of 5.2 l in all: 28.9 % of its volume."
// `objects` are the objects of the scenario.
std::string FillText(const ScenarioSpec& spec, const ObjectSet& objects);

}  // namespace pickbed::eval
