#pragma once

// A run of one scenario: trials in worker processes, written to a results folder. A run is a sweep
// with one configuration (see eval/sweep/sweep.h). It also writes
//
//   OUT/pick_chances.csv  success probability of each hypothesis, if tolerance models are given
//   OUT/pictures/trial_0000/attempt_00_{color,depth,overlay,after}.png  of the first trials
//   OUT/pictures/trial_0008/attempt_02_failed.jpg                    of failed picks of the others
//
// All files are identical, byte by byte, for any number of workers. Only the times in the store and
// timings.csv differ.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "eval/summary/run_summary.h"
#include "eval/sweep/sweep.h"
#include "eval/tolerance/maps.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Options of a call of RunScenario.
struct RunOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool resume = false;         // continue in a folder that holds finished trials
  bool retry_crashed = false;  // repeat the trials that crashed in an earlier call
  int picture_trials = 4;      // trials 0 .. picture_trials - 1 get pictures
  // Later trials below this number get a small picture of each failed pick.
  int failure_picture_trials = 1000;
  std::vector<int> only_trials;  // ascending; empty = all of the scenario
  OracleStages truth;            // stages with ground truth substituted
  ToleranceMaps tolerance;       // of the objects; only used in the reports
  // Folder of a BOP data set with all images (eval/sweep/run_images.h); empty = none.
  std::filesystem::path bop_out;
};

// Result of RunScenario.
struct RunReport {
  RunSummary summary;
  std::vector<TrialResult> trials;  // all finished trials, ordered by trial
  bool interrupted = false;
  std::vector<CrashedTrial> crashed;  // crashed in this call
};

// Runs all trials and returns their summary. It forks worker processes; see RunInWorkers for the
// restrictions. Throws InputError for unknown names and a broken model file. Also throws it for an
// output folder that cannot be written, holds other results, or holds finished trials while
// `resume` is false. The same holds for the folder of the images.
RunReport RunScenario(const ScenarioSpec& spec, const ObjectSet& objects, const RunOptions& options,
                      const RunListener& listener);

// Writes trials that this process ran as the results folder of a run: the same files as
// RunScenario() without pictures. The trials must have the bins 0, 1, ... With `own_grasps`, a
// caller chose the grasps; such trials cannot be combined with a run of the scenario. Throws
// InputError without trials, and for an output folder that cannot be written, is in use, or holds
// trials.
void WriteRun(const ScenarioSpec& spec, const ObjectSet& objects,
              std::span<const TrialResult> trials, bool own_grasps,
              const std::filesystem::path& out);

// Returns a text that identifies the inputs of a run; equal texts mean that trials can be combined.
// It covers the settings (except number of trials, stop width and cycle times), gripper, sensor,
// trained model, calibration, files of the programs of estimator and planner (of a server, the name
// and version that it reports), and stages with ground truth substituted.
// Meshes of the objects and the bin count by content, not by path.
std::string RunIdentity(const ScenarioSpec& spec, const ObjectSet& objects,
                        const OracleStages& truth = {});
// Returns the part of this text about the files of the estimator: trained model, calibration,
// program and model of shape completion.
std::string EstimatorFilesText(const ScenarioSpec& spec);
// Returns the stages with ground truth substituted from such a text; none if it names none.
OracleStages TruthIn(const std::string& identity);

// Returns a sweep with this scenario as its only configuration.
Sweep SweepOfOne(const ScenarioSpec& spec, const ObjectSet& objects,
                 const OracleStages& truth = {});

}  // namespace pickbed::eval
