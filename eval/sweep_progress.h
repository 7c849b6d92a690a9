#pragma once

// How run, sweep and budget tell how far they are and what crashed.

#include <functional>
#include <vector>

#include "eval/progress.h"
#include "eval/sweep.h"

namespace pickbed {

ProgressState ProgressOf(const RunState& state);

// Shows trials as they come in, and what a worker says between two of them. `progress` must outlive
// it.
RunListener ShowOn(ProgressLine& progress, const std::function<bool()>& stop);

// Throws std::runtime_error, which names the first, when there are any.
void RequireNoCrash(const std::vector<CrashedTrial>& crashed);

}  // namespace pickbed
