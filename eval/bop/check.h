#pragma once

// What is wrong with a BOP data set.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pickbed::bop {

struct CheckReport {
  std::vector<std::string> faults;  // one line each: file, and what is wrong in it
  int objects = 0;
  int scenes = 0;
  int images = 0;
  int instances = 0;
};

// Looks at everything: models against models_info, cameras, truth against images, masks against
// counts, targets against truth. mask, mask_visib and target files may be absent; where they are
// not, they have to be whole. `on_scene` hears of every scene before it is looked at.
CheckReport CheckDataset(const std::filesystem::path& root,
                         const std::function<void(const std::string& scene)>& on_scene = {});

}  // namespace pickbed::bop
