#pragma once

// Results of a run or sweep in one SQLite file: one transaction a trial, so that a kill at any
// moment loses at most the trials in flight.
//
// A store holds *points*: sets of settings of a sweep's grid; a plain run has the one point 0. A
// trial's number is its own in the store (RUN#trial): point p owns [first_trial, first_trial +
// trials). Files of schema 4 on are read; writing to one makes it one of this version.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/statistics.h"
#include "eval/trial.h"

namespace pickbed {

struct StoredPoint {
  int point = 0;
  std::string name;  // "estimator.name=ppf,sensor=time_of_flight"; empty for a plain run's
  int first_trial = 0;
  int trials = 0;  // that belong to it, finished or not
  uint64_t seed = 0;
  std::string identity;  // equal where trials can be joined, see RunIdentity in eval/run.h
  std::string settings;  // effective scenario, with the paths of meshes relative to the folder
};

struct StoreHead {
  std::string identity;  // equal where stores hold the same points
  std::vector<StoredPoint> points;
};

// A trial that ended its worker twice.
struct CrashedTrial {
  int trial = 0;
  int point = 0;
  int scene = 0;
  uint64_t seed = 0;
  std::string why;
};

// The settings that FOLDER/results.sqlite was written with (StoreHead::identity); none when there
// is no such file, or nothing in it yet. Throws InputError when it is no results store.
std::optional<std::string> StoredSettings(const std::filesystem::path& folder);

// The value of the line "seed: N" of a settings text, 0 without one.
uint64_t SeedIn(const std::string& settings);

class ResultsStore {
 public:
  // Opens or creates FOLDER/results.sqlite. Throws InputError when the folder is not writable, the
  // file is damaged or of a later version, or it holds trials of other settings.
  ResultsStore(const std::filesystem::path& folder, const StoreHead& head);
  // Of the one point that `settings` make.
  ResultsStore(const std::filesystem::path& folder, const std::string& settings);
  // Opens what is there and leaves it as it is, also where nobody may write. Throws InputError when
  // there is no store.
  static ResultsStore OpenToRead(const std::filesystem::path& folder);
  // Removes what writers that were ended, not closed, have left beside the file. Nothing is lost
  // where it stays.
  static void Tidy(const std::filesystem::path& folder);
  ~ResultsStore();
  ResultsStore(ResultsStore&&) noexcept;

  // All of a trial in one transaction. Throws InputError on a full disk; what was there stays.
  void Write(const TrialResult& result);
  void WriteCrashed(const CrashedTrial& crashed);
  void ForgetCrashed();                         // so that they are tried again
  void Forget(const std::vector<int>& trials);  // with all that belongs to them

  const StoreHead& head() const;
  std::vector<int> FinishedTrials() const;  // ascending; those that crashed are among them
  std::vector<CrashedTrial> Crashed() const;
  // Successes of attempts of each trial with a look, read without the rest of it.
  std::map<int, Cluster> Outcomes() const;
  // By trial, with their seconds, those that did not crash.
  std::vector<TrialResult> ReadAll() const;
  // The same of trials [first, end).
  std::vector<TrialResult> Read(int first, int end) const;
  // All trials one after the other, of which few are held at a time.
  void ForEach(const std::function<void(const TrialResult&)>& visit) const;

 private:
  struct Impl;
  explicit ResultsStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
