#pragma once

// Merges the results stores of shards, or of independent runs, into one store.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/summary/result_files.h"

namespace pickbed::eval {

// Options of MergeStores.
struct MergeOptions {
  // Also accept stores with different settings. Their configurations are kept side by side and
  // named by folder.
  bool compare = false;
};

// Result of MergeStores.
struct MergeReport {
  std::vector<ConfigurationSummary> configurations;
  int trials = 0;   // in the merged store, including crashed ones
  int missing = 0;  // trials of its configurations that are in no input store
  int doubled = 0;  // trials that were identical in several stores
};

// Writes OUT/results.sqlite and the files of eval/summary/result_files.h. A store that already
// exists in OUT must have the same settings; its trials are included. Throws InputError if stores
// have different settings (unless `compare`), or if two stores hold different results for one
// trial.
MergeReport MergeStores(const std::vector<std::filesystem::path>& folders,
                        const std::filesystem::path& out, const MergeOptions& options = {});

}  // namespace pickbed::eval
