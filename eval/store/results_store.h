#pragma once

// Results of a run or sweep in one SQLite file. Each trial is one transaction, so a kill at any
// moment loses at most the trials in progress.
//
// A store holds configurations (StoredConfiguration): the sets of settings of a sweep's grid. A
// plain run has only configuration 0. Trial numbers are unique in the store (RUN#trial): a
// configuration owns the trials [first_trial, first_trial + trials). Files of schema 4 and later
// can be read. Opening such a file for writing converts it to the current version.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

inline constexpr char kStoreFile[] = "results.sqlite";  // in a results folder

struct StoredConfiguration {
  int number = 0;
  std::string name;  // "estimator.name=ppf,sensor=time_of_flight"; empty for a plain run
  int first_trial = 0;
  int trials = 0;  // number of trials that belong to it, finished or not
  uint64_t seed = 0;
  std::string identity;  // trials can be merged if equal, see RunIdentity in eval/sweep/run.h
  std::string settings;  // effective scenario; mesh paths are relative to the folder
};

struct StoreHead {
  std::string identity;  // equal if two stores hold the same configurations
  std::vector<StoredConfiguration> configurations;
};

// A trial whose worker crashed twice.
struct CrashedTrial {
  int trial = 0;
  int configuration = 0;
  BinIndex bin_index{0};
  uint64_t seed = 0;
  std::string why;
};

// Returns StoreHead::identity of a sweep: one ConfigurationIdentity() per configuration.
std::string SweepIdentity(const std::vector<StoredConfiguration>& configurations);
// Returns the line of one configuration in SweepIdentity().
std::string ConfigurationIdentity(int number, int trials, const std::string& identity_hash,
                                  const std::string& name);

// Returns the settings with which FOLDER/results.sqlite was written (StoreHead::identity), or
// nullopt if the file does not exist or is still empty. Throws InputError if it is no results
// store.
std::optional<std::string> StoredSettings(const std::filesystem::path& folder);

// Returns the value of the line "seed: N" of a settings text, 0 if there is none.
uint64_t SeedIn(const std::string& settings);

// What is checked when a store is opened: its version only, also its tables, or also that all rows
// belong together (eval/store/store_check.h). Programs that ask for the progress of a run again and
// again check the version only. Programs that copy rows unread check all.
enum class StoreChecks { kVersion, kTables, kRows };

// The results file of a run or sweep. Several processes can write to it at the same time.
class ResultsStore {
 public:
  // Opens or creates FOLDER/results.sqlite for writing. Throws InputError if the folder is not
  // writable, the file is damaged or of a later version, or it holds trials of other settings.
  ResultsStore(const std::filesystem::path& folder, const StoreHead& head);
  // Same, with `settings` as the only configuration.
  ResultsStore(const std::filesystem::path& folder, const std::string& settings);
  // Opens an existing store without changing it; the file may be read-only. A file of an earlier
  // version is converted in memory. Throws InputError if there is no store, or if it is damaged.
  static ResultsStore OpenToRead(const std::filesystem::path& folder,
                                 StoreChecks checks = StoreChecks::kTables);
  // Removes the journal file that killed writers left beside the store. A journal that remains does
  // no harm.
  static void Tidy(const std::filesystem::path& folder);
  ~ResultsStore();
  ResultsStore(ResultsStore&&) noexcept;

  // Writes a trial in one transaction. Throws InputError on a full disk; earlier trials are kept.
  void Write(const TrialResult& result);
  void WriteCrashed(const CrashedTrial& crashed);
  void ForgetCrashed();                         // removes crashed trials, so that they are repeated
  void Forget(const std::vector<int>& trials);  // removes trials with all their rows

  const StoreHead& head() const;
  std::vector<int> FinishedTrials() const;  // ascending; includes crashed trials
  std::vector<CrashedTrial> Crashed() const;
  // Returns (successes, executed grasps) of each trial with at least one attempt. Reads no other
  // data.
  std::map<int, Cluster> Outcomes() const;
  // Returns (successes, executed grasps) of a trial, or nullopt if it is not in the store or
  // crashed.
  std::optional<Cluster> OutcomeOf(int trial) const;
  // Reads all trials that did not crash, with their times, ordered by trial number.
  std::vector<TrialResult> ReadAll() const;
  // Same, for trials [first, end).
  std::vector<TrialResult> Read(int first, int end) const;
  // Visits all trials that did not crash. Holds only a few hundred in memory at a time.
  void ForEach(const std::function<void(const TrialResult&)>& visit) const;

 private:
  struct Impl;
  explicit ResultsStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::eval
