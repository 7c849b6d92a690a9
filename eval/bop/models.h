#pragma once

// Loads the models of a BOP data set as objects for estimation or training.

#include <filesystem>
#include <map>
#include <set>
#include <vector>

#include "eval/bop/read_dataset.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

struct DatasetObjects {
  ObjectSet objects;
  std::vector<int> ids;  // BOP obj_id of each object
};

// Loads the objects `wanted`, in order of their ids. Name and mesh hash come from the data set's
// card. Without a card, the name is obj_000001 and the hash is computed. Throws InputError for an
// id that is not in `models` and for a broken mesh.
DatasetObjects LoadDatasetObjects(const std::filesystem::path& root, const std::set<int>& wanted,
                                  const std::map<int, DatasetModelInfo>& models);

// Loads all objects of the data set. Throws InputError as above, and if it has no object.
DatasetObjects LoadDatasetObjects(const std::filesystem::path& root);

}  // namespace pickbed::eval
