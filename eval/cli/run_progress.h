#pragma once

// Progress and messages of the commands run, sweep and budget.

#include <functional>
#include <string>
#include <vector>

#include "eval/runtime/progress.h"
#include "eval/sweep/sweep.h"
#include "scenes/scenario/load_objects.h"

namespace pickbed::eval {

// Converts the progress of a run for the progress line.
ProgressState ProgressOf(const RunState& state);

// Returns a listener that shows finished trials and the messages of workers. `progress` must
// outlive it.
RunListener ShowOn(ProgressLine& progress, const std::function<bool()>& stop);

// Returns a function that shows the objects that are loaded or prepared, with the time left. It
// shows nothing in the first 2 s. `progress` must outlive it.
ObjectProgress ShowObjectsOn(ProgressLine& progress);

// Returns a line for each gripper that cannot hold one of the objects to be picked. Empty with one
// gripper, which must hold all, and for planners without poses.
std::string UnfitTools(const ScenarioSpec& spec, const ObjectSet& objects);

// Throws std::runtime_error if trials crashed. The message names the first one.
void RequireNoCrash(const std::vector<CrashedTrial>& crashed);

}  // namespace pickbed::eval
