#pragma once

// Consistency check of a BOP data set.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

struct CheckDatasetReport {
  std::vector<std::string> faults;  // one line each: the file and the fault in it
  int objects = 0;
  int scenes = 0;
  int images = 0;
  int instances = 0;
};

// Checks the whole data set: models against models_info, cameras, ground truth against images,
// masks against pixel counts, and targets against ground truth. mask, mask_visib and target files
// may be absent. If one exists, it must be complete. `on_scene` is called before each scene with
// "SPLIT/SCENE". Returns the faults and the counts. Throws InputError if `root` is no folder.
CheckDatasetReport CheckDataset(const std::filesystem::path& root,
                                const std::function<void(const std::string& scene)>& on_scene = {});

}  // namespace pickbed::eval
