#pragma once

// A whole run: trials over worker processes into a results folder, which is a sweep of one point
// (see eval/sweep.h) with
//
//   OUT/pick_chances.csv the chance of every hypothesis, where tolerance maps are given
//   OUT/pictures/trial_0000/pick_00_{color,depth,overlay,after}.png    of the first trials
//   OUT/pictures/trial_0008/pick_02_lost.jpg                           of lost picks of the others
//
// All but the store's timings and timings.csv are the same bytes for any number of workers.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/summary.h"
#include "eval/sweep.h"
#include "eval/tolerance_maps.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

struct RunOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool resume = false;             // go on in a folder that holds finished trials
  bool retry_crashed = false;      // those of an earlier call are tried again
  int picture_trials = 4;          // trials 0 .. picture_trials - 1 get pictures
  int lost_picture_trials = 1000;  // later ones below this get a small one of each lost pick
  std::vector<int> only_trials;    // ascending; empty = all of the scenario
  TruthStages truth;               // stages that are fed with truth
  ToleranceMaps tolerance;         // of the parts, for the reports alone
};

struct RunReport {
  RunSummary summary;
  std::vector<TrialResult> trials;  // all that are finished, by trial
  bool interrupted = false;
  std::vector<CrashedTrial> crashed;  // of this call
};

// Throws InputError for unknown names, a broken model, and a folder that cannot be written, holds
// other results, or holds finished trials when `resume` is not set. Forks, see eval/workers.h.
RunReport RunScenario(const ScenarioSpec& spec, const ObjectSet& objects, const RunOptions& options,
                      const RunListener& listener);

// What must be equal for two runs to be one: the settings but the number of trials, where they
// stop and the cycle's times, the gripper, the sensor, the meshes of parts and bin wherever they
// lie, and the trained model; and which stages were fed with truth.
std::string RunIdentity(const ScenarioSpec& spec, const ObjectSet& objects,
                        const TruthStages& truth = {});
// Those stages again; none where the text says of none.
TruthStages TruthIn(const std::string& identity);

// The sweep that a run is.
Sweep SweepOfOne(const ScenarioSpec& spec, const ObjectSet& objects, const TruthStages& truth = {});

}  // namespace pickbed
