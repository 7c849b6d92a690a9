#pragma once

// Benchmarks of work that the program distributes over processes, one per core.

#include <benchmark/benchmark.h>

#include <functional>

#include "tests/support/layer.h"

namespace pickbed::tests {

// Measures steps of work in state.range(0) parallel processes. `make_work` is called once in each
// process and returns the function of one step. Each benchmark iteration runs `steps` steps in
// every process and takes the wall time until all are done, so the benchmark must use manual time.
// Counts `items_per_step` items per step. Also reports the items per CPU second, which other work
// on the machine disturbs less.
void MeasureInProcesses(benchmark::State& state, int steps,
                        const std::function<std::function<void()>()>& make_work,
                        int items_per_step = 1);

}  // namespace pickbed::tests
