#pragma once

// Joins the stores of shards, or of any runs, into one.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/sweep_files.h"

namespace pickbed {

struct MergeOptions {
  // Stores of unlike settings are taken too: their points stand side by side, named by folder.
  bool compare = false;
};

struct MergeReport {
  std::vector<PointSummary> points;
  int trials = 0;   // in the joined store, crashed ones too
  int missing = 0;  // that belong to its points and are in no shard
  int doubled = 0;  // that several stores held, alike
};

// Writes OUT/results.sqlite, and from it what eval/sweep_files.h says. A store that OUT holds
// already must be of the same settings and is joined in. Throws InputError for stores of unlike
// settings (unless `compare`) and for a trial that two stores tell differently.
MergeReport MergeStores(const std::vector<std::filesystem::path>& folders,
                        const std::filesystem::path& out, const MergeOptions& options = {});

}  // namespace pickbed
