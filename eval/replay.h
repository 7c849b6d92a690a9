#pragma once

// One trial run again from its record alone, and where it first went another way.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/results_store.h"
#include "eval/trial.h"
#include "eval/trial_observer.h"

namespace pickbed {

// RUN#trial: a results folder and the number of one of its trials.
struct TrialAddress {
  std::filesystem::path run;
  int trial = 0;
};
// Throws InputError for text without '#' or whose end is no number.
TrialAddress ParseTrialAddress(const std::string& text);

// All that a trial was made from, and what came of it.
struct RecordedTrial {
  ScenarioSpec spec;
  ObjectSet objects;
  TruthStages truth;
  TrialResult result;                   // without looks where it crashed
  std::optional<CrashedTrial> crashed;  // it ended its worker, nothing else is recorded
  // What is not as it was when the trial ran, a line each: a part, the model, a file of settings.
  std::vector<std::string> changes;
};
// Settings come from the store; meshes, model, gripper and sensor from where the settings say,
// parts that the scenario names from `catalog`. Throws InputError where there is no such run or
// trial, for a store of a later version, and naming what is missing of a mesh or other file.
RecordedTrial ReadRecordedTrial(const TrialAddress& address, const std::string& catalog);

enum class ReplayVerdict {
  kSame,
  kDiffers,
  kNotRecorded,  // the record is of a version without hashes
  kAltered,      // what the record holds is not what its own hash says: it was changed since
  kOnlyRecorded,
  kOnlyReplayed,
};

struct StageReplay {
  int look = 0;
  TrialStage stage = TrialStage::kScene;
  uint64_t recorded = 0, replayed = 0;  // hashes, 0 = none
  ReplayVerdict verdict = ReplayVerdict::kSame;
  std::string what;  // first number that differs, see eval/record_difference.h
};

struct ReplayReport {
  TrialResult replayed;
  std::vector<StageReplay> stages;  // in the order in which a trial reaches them
  // Null where all that is recorded is the same.
  const StageReplay* FirstDifference() const;
};

// Runs it again; `observer` sees its stages. Throws what the trial throws.
ReplayReport ReplayTrial(
    const RecordedTrial& recorded, TrialObserver* observer,
    const std::function<void(std::string_view what, double share)>& on_progress);

// The comparison alone.
std::vector<StageReplay> CompareStages(const std::vector<PickRecord>& recorded,
                                       const std::vector<PickRecord>& replayed);

// A line a stage, and the first that differs; for people.
std::string ReplayTable(const ReplayReport& report);
// look, stage, recorded, replayed, verdict.
std::string ReplayCsv(const ReplayReport& report);

}  // namespace pickbed
