#pragma once

// Benchmarks of work that the program spreads over processes, one a core.

#include <benchmark/benchmark.h>

#include <functional>

namespace pickbed {

// `make_work` builds in each process what one step of the returned work then uses. Each iteration
// of the benchmark lets state.range(0) processes do `steps` steps each and takes the wall time till
// all are done, so the benchmark must use manual time. Counts `items_per_step` items a step, and
// says how many a CPU second gives, which other work on the machine disturbs less.
void MeasureInProcesses(benchmark::State& state, int steps,
                        const std::function<std::function<void()>()>& make_work,
                        int items_per_step = 1);

}  // namespace pickbed
