#pragma once

// The tables of `pickbed benchmark`, each a command of its own: one cmd_benchmark_NAME.cpp and one
// row in cmd_benchmark.cpp.

#include <string>
#include <vector>

#include "scenes/object_catalog.h"

namespace pickbed {

int BenchmarkAllCommand(int argc, char** argv);
int BenchmarkCropsCommand(int argc, char** argv);
int BenchmarkBinsCommand(int argc, char** argv);

// Mesh files as parts that no catalog knows, named after their files, of any mass: crops weigh
// nothing. `unit`: of their coordinates, as in a catalog. Throws InputError.
ObjectSet LoadMeshFiles(const std::vector<std::string>& meshes, const std::string& unit);

}  // namespace pickbed
