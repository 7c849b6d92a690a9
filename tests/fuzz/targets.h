#pragma once

// Everything of pickbed that reads files or messages of others, one target per format. A target
// gets the bytes of the file. It may throw InputError or MessageError, and nothing else.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tests/support/layer.h"

namespace pickbed::tests {

struct FuzzTarget {
  std::string name;
  // Reads `bytes` with the code under test. `folder` is a private folder, in which the target has
  // the files that the code needs besides.
  std::function<void(const std::filesystem::path& folder, const std::string& bytes)> run;
  // Contents that the code accepts. Mutations begin with them.
  std::function<std::vector<std::string>()> seeds;
  bool reads_file = true;     // its errors name the file
  bool accepts_seeds = true;  // false: the seeds are edits that damage a file
  int replays = 40;           // mutations that the tests run; fewer for a slow target
};

// All targets. They are made once.
std::span<const FuzzTarget> FuzzTargets();

// Returns the target of this name. Throws InputError with the known names.
const FuzzTarget& FindFuzzTarget(const std::string& name);

}  // namespace pickbed::tests
