#pragma once

// The models of a BOP data set as parts to be estimated or learned.

#include <filesystem>
#include <map>
#include <set>
#include <vector>

#include "eval/bop/dataset.h"
#include "scenes/object_model.h"

namespace pickbed::bop {

struct DatasetParts {
  ObjectSet objects;
  std::vector<int> ids;  // of each
};

// Those of `wanted`, in order of their ids. A part has the name and mesh hash that the data set's
// card gives it, else obj_000001. Throws InputError for an id that is not in `models` and for a
// broken mesh.
DatasetParts LoadParts(const std::filesystem::path& root, const std::set<int>& wanted,
                       const std::map<int, ModelInfo>& models);

// All of the data set. Throws InputError, also when it has none.
DatasetParts LoadParts(const std::filesystem::path& root);

}  // namespace pickbed::bop
