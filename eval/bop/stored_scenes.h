#pragma once

// The scenes that the images of a data set show, with everything that physics needs to continue:
// poses of the instances, their deviations, and the objects by name with hashes. The bin and all
// other settings are in stored_scenario.yaml of the data set. Only data sets of pickbed have these
// files.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// The scenes of one scene folder. Several images can show the same scene.
struct StoredScenes {
  uint64_t seed = 0;
  BinIndex bin_index{0};
  std::vector<double> sizes;            // size deviation by object, as a share
  std::vector<Scene> scenes;            // in the order of the images
  std::map<int, size_t> of_image = {};  // image id -> index into `scenes`

  // Adds an image. A scene that is equal to the last one is stored once.
  void Add(int image_id, const Scene& scene);
  // Returns the scene that an image shows. Throws InputError, which names `folder`, without one.
  const Scene& Of(int image_id, const std::filesystem::path& folder) const;
};

// Returns the text of stored_scenes.json. `objects` are the objects of the scenario.
std::string StoredScenesText(const StoredScenes& stored, const ObjectSet& objects);

// Reads stored_scenes.json of a scene folder. The scenes get the bin and the objects of the
// scenario. Throws InputError if the file is missing or broken, or if the bin or an object differs
// from the one that the scenes were made with.
StoredScenes ReadStoredScenes(const std::filesystem::path& folder, const Bin& bin,
                              const ObjectSet& objects);

}  // namespace pickbed::eval
