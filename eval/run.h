#pragma once

// A whole run: trials over worker processes into a results folder.
//
//   OUT/results.sqlite   everything, see eval/results_store.h
//   OUT/scenario.yaml    the effective settings
//   OUT/timings.csv      seconds by trial and stage
//   OUT/{summary.json,trials.csv,picks.csv,parts.csv}
//   OUT/pick_chances.csv the chance of every hypothesis, where tolerance maps are given
//   OUT/pictures/trial_0000/pick_00_{color,depth,overlay,after}.png
//
// All but the store's timings and timings.csv are the same bytes for any number of workers.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/summary.h"
#include "eval/tolerance_maps.h"
#include "eval/workers.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

struct RunOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool resume = false;           // go on in a folder that holds finished trials
  int picture_trials = 4;        // trials 0 .. picture_trials - 1 get pictures
  std::vector<int> only_trials;  // ascending; empty = all of the scenario
  TruthStages truth;             // stages that are fed with truth
  ToleranceMaps tolerance;       // of the parts, for the reports alone
};

// How far a run is.
struct RunState {
  int done = 0, total = 0;          // trials, with those of an earlier run
  int done_before = 0;              // of an earlier run
  int attempts = 0, successes = 0;  // of this run
};

struct RunListener {
  std::function<void(const RunState& state)> on_trial;
  std::function<void(const std::string& line)> on_message;
  std::function<bool()> stop;
};

struct RunReport {
  RunSummary summary;
  std::vector<TrialResult> trials;  // all that are finished, by trial
  bool interrupted = false;
  std::vector<LostItem> lost;  // trials that threw or crashed
};

// Throws InputError for unknown names, a broken model, and a folder that cannot be written, holds
// other results, or holds finished trials when `resume` is not set. Forks, see eval/workers.h.
RunReport RunScenario(const ScenarioSpec& spec, const ObjectSet& objects, const RunOptions& options,
                      const RunListener& listener);

// What must be equal for two runs to be one: the settings but the number of trials and the cycle's
// times, the gripper, the sensor, the meshes of parts and bin wherever they lie, and the trained
// model; and which stages were fed with truth.
std::string RunIdentity(const ScenarioSpec& spec, const ObjectSet& objects,
                        const TruthStages& truth = {});
// Those stages again; none where the text says of none.
TruthStages TruthIn(const std::string& identity);

}  // namespace pickbed
