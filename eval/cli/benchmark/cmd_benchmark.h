#pragma once

// Tables of `pickbed benchmark`. Each is a command: one cmd_benchmark_NAME.cpp and one row in
// cmd_benchmark.cpp.

#include <span>
#include <string>
#include <vector>

#include "eval/cli/commands.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::eval {

// Returns all tables, in the order of the help.
std::span<const CommandRow> BenchmarkTables();

// Runs `pickbed benchmark all`. Returns the exit status.
int BenchmarkAllCommand(int argc, char** argv);
// Runs `pickbed benchmark crops`. Returns the exit status.
int BenchmarkCropsCommand(int argc, char** argv);
// Runs `pickbed benchmark bins`. Returns the exit status.
int BenchmarkBinsCommand(int argc, char** argv);

// Runs `pickbed benchmark rooms`. Returns the exit status.
int BenchmarkRoomsCommand(int argc, char** argv);

// Loads mesh files as objects outside the catalog, named after their files. Their mass is
// arbitrary, because crops do not use it. `unit` is the unit of the coordinates, as in a catalog.
// Throws InputError.
ObjectSet LoadMeshFiles(const std::vector<std::string>& meshes, const std::string& unit);

}  // namespace pickbed::eval
