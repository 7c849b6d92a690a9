#pragma once

// Which images of a split are to be worked on, and what is to be found in them.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "eval/bop/dataset.h"

namespace pickbed::bop {

struct ImageTargets {
  bool localised = false;     // BOP19 has targets here
  bool detected = false;      // BOP24 has this image
  std::map<int, int> counts;  // BOP19: object -> instances to be found
};

struct SplitTargets {
  std::map<int, std::map<int, ImageTargets>> scenes;  // scene -> image
  std::vector<std::string> notes;                     // what stands in for files that are absent
};

// From test_targets_bop19.json and _bop24.json. Without the first: every instance of at least 10 %
// visible, as BOP chose its targets; without the second: every image. Throws InputError when the
// split has no scene.
SplitTargets TargetsOf(const std::filesystem::path& root, const std::string& split);

}  // namespace pickbed::bop
