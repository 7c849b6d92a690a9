#pragma once

// Repeats one trial from its record and finds the first stage that differs.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/store/results_store.h"
#include "eval/trial/observer.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

inline constexpr char kStagesFile[] = "stages.csv";

// Address RUN#TRIAL: a results folder and the number of one of its trials.
struct TrialAddress {
  std::filesystem::path run;
  int trial = 0;
};
// Parses an address. Throws InputError if there is no '#' or no trial number after it.
TrialAddress ParseTrialAddress(const std::string& text);

// Inputs and result of a recorded trial.
struct RecordedTrial {
  ScenarioSpec spec;
  ObjectSet objects;
  // Stages with ground truth substituted.
  OracleStages truth;
  TrialResult result;  // without attempts if the trial crashed
  // Set if the trial crashed its worker; nothing else is recorded then.
  std::optional<CrashedTrial> crashed;
  // Inputs that have changed since the trial ran, one line each: an object, the model, a settings
  // file.
  std::vector<std::string> changes;
};
// Reads a trial. The settings come from the store. Meshes, model, gripper and sensor are read from
// the files named there, objects from `catalog`. Throws InputError if the run or trial does not
// exist, if the store has a later version, if the trial is damaged, or if a file is missing.
RecordedTrial ReadRecordedTrial(const TrialAddress& address, const std::string& catalog);

// Throws InputError if the stored settings name a program or a server that repeating a trial would
// use, unless `allowed`. The results of another person can name any program.
//   results  their name in the message
void RequireProgramsAllowed(const ScenarioSpec& spec, const std::string& results, bool allowed);

// Lists the recorded trials of a run or sweep: a header and one line per trial with its number,
// bin, attempts, successful picks and status: finished, crashed, or "damaged: " and the reason.
// Throws InputError if the folder has no results store.
std::string TrialList(const std::filesystem::path& run);

// Result of the comparison of one stage.
enum class ReplayVerdict {
  kSame,
  kDiffers,
  kNotRecorded,  // the record is from a version without hashes
  kAltered,      // the recorded values do not match their own hash: the record was changed
  kOnlyRecorded,
  kOnlyReplayed,
};

// Comparison of one stage of one attempt.
struct StageReplay {
  int attempt = 0;
  TrialStage stage = TrialStage::kScene;
  uint64_t recorded = 0, replayed = 0;  // hashes, 0 = none
  ReplayVerdict verdict = ReplayVerdict::kSame;
  std::string what;  // first value that differs, see eval/replay/first_difference.h
};

// The repeated trial and its comparison.
struct ReplayReport {
  TrialResult replayed;
  std::vector<StageReplay> stages;  // in the order of the trial
  // Returns the first stage that differs; null if everything recorded is the same.
  const StageReplay* FirstDifference() const;
};

// Repeats the trial; `observer` is notified of its stages. Throws what the trial throws.
ReplayReport ReplayTrial(
    const RecordedTrial& recorded, TrialObserver* observer,
    const std::function<void(std::string_view what, double share)>& on_progress);

// Compares two records of a trial without running it.
std::vector<StageReplay> CompareStages(const std::vector<AttemptRecord>& recorded,
                                       const std::vector<AttemptRecord>& replayed);

// Returns the result for the console: one line per attempt, one per stage that is not the same, and
// the first difference. With `verbose`, one line per stage with its hashes.
std::string ReplayTable(const ReplayReport& report, bool verbose = false);
// Returns a CSV table with one line per stage.
std::string ReplayCsv(const ReplayReport& report);
// Returns the columns of ReplayCsv().
ResultColumns ReplayColumns();

}  // namespace pickbed::eval
