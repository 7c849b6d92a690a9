#pragma once

// Results of a run in one SQLite file: one transaction a trial, so that a kill at any moment
// loses at most the trials in flight.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/trial.h"

namespace pickbed {

// The settings that FOLDER/results.sqlite was written with; none when there is no such file. Throws
// InputError when it is no results store.
std::optional<std::string> StoredSettings(const std::filesystem::path& folder);

class ResultsStore {
 public:
  // Opens or creates FOLDER/results.sqlite. Throws InputError when the folder is not writable or
  // holds trials of other settings (`settings` is the effective scenario text).
  ResultsStore(const std::filesystem::path& folder, const std::string& settings);
  ~ResultsStore();

  // All of a trial in one transaction. Throws InputError on a full disk; what was there stays.
  void Write(const TrialResult& result);
  std::vector<int> FinishedTrials() const;   // ascending
  std::vector<TrialResult> ReadAll() const;  // by trial, with their seconds

 private:
  struct Impl;
  friend std::optional<std::string> StoredSettings(const std::filesystem::path& folder);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
