#pragma once

// The tables of `pickbed benchmark`, each a command of its own: one cmd_benchmark_NAME.cpp and one
// row in cmd_benchmark.cpp.

namespace pickbed {

int BenchmarkCropsCommand(int argc, char** argv);
int BenchmarkBinsCommand(int argc, char** argv);

}  // namespace pickbed
