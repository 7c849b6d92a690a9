#pragma once

// Tables of `pickbed benchmark`. Each is a command: one cmd_benchmark_NAME.cpp and one row in
// cmd_benchmark.cpp.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::eval {

int BenchmarkAllCommand(int argc, char** argv);
int BenchmarkCropsCommand(int argc, char** argv);
int BenchmarkBinsCommand(int argc, char** argv);

// Loads mesh files as objects outside the catalog, named after their files. Their mass is
// arbitrary, because crops do not use it. `unit` is the unit of the coordinates, as in a catalog.
// Throws InputError.
ObjectSet LoadMeshFiles(const std::vector<std::string>& meshes, const std::string& unit);

}  // namespace pickbed::eval
