#pragma once

// Runs a grid of settings in worker processes, written to one results folder. A run is a sweep with
// one configuration.
//
//   OUT/results.sqlite      all results, see eval/store/results_store.h
//   OUT/shards/shard_1_of_8/results.sqlite    of a shard, instead; `pickbed merge` joins them
//   OUT/scenario.yaml       effective settings of a run
//   OUT/sweep.yaml, OUT/configurations/00_NAME.yaml   of a sweep and of each of its configurations
//   OUT/logs/estimator_1.log   what an estimator that is another program wrote to standard error
//   OUT/lock                held while a process writes to the folder
//   and the files of eval/summary/result_files.h, computed from the store at the end
//
// All files are identical, byte by byte, for any number of workers and shards. Only times differ.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/runtime/process_pool.h"
#include "eval/store/results_store.h"
#include "eval/summary/result_files.h"
#include "scenes/base/ids.h"
#include "scenes/base/settings.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// One configuration of a sweep. It owns the trials [first_trial, first_trial + trials) of the
// store, which have the scenes 0, 1, ...
struct Configuration {
  int number = 0;
  std::string name;  // such as "estimator.name=ppf,sensor=ideal"; empty in a run
  ScenarioSpec spec;
  ObjectSet objects;
  std::string identity;  // see RunIdentity in eval/sweep/run.h
  int first_trial = 0;
  int trials = 0;
};

// All configurations of a sweep.
struct Sweep {
  std::vector<Configuration> configurations;
  std::string yaml;  // content of OUT/sweep.yaml; empty for a run
};
// Returns the configuration that owns a trial.
const Configuration& ConfigurationOf(const Sweep& sweep, int trial);

// Pictures to be written by a trial, see eval/sweep/attempt_pictures.h.
enum class PicturesWanted { kNone, kOfFailedPicks, kAll };
// Pictures of one trial and their folder.
struct PictureOrder {
  PicturesWanted wanted = PicturesWanted::kNone;
  std::filesystem::path folder;
};
// Runs one trial of a configuration in a worker. The sweep fills in the trial number and the
// configuration.
using DoTrial = std::function<TrialResult(BinIndex bin_index, const PictureOrder& pictures)>;
// Creates a DoTrial in a worker, which uses it for many trials of the configuration. Throws
// InputError if a file named by the settings does not exist.
using MakeDoTrial =
    std::function<DoTrial(const Configuration& configuration, const WorkerPlan::Say& say)>;
// Returns the standard trial: drop, capture, estimate, pick. `bop_out`: folder of the data set that
// gets all images (eval/sweep/run_images.h); empty = none.
MakeDoTrial PickingTrials(const TrialOptions& options = {},
                          const std::filesystem::path& bop_out = {});

// Shard `index` (1 .. count) of the trials of a sweep. Trials are ordered by scene, then by
// configuration, so that compared trials are in one shard. A scene at the border of two shards is
// split between them.
struct Shard {
  int index = 1;
  int count = 1;
  void Visit(SettingsVisitor& v);
};
// Parses a text such as "3/8". Throws InputError.
Shard ParseShard(const std::string& text);
// Returns the folder of the store of a shard; `out` itself if there is only one shard.
std::filesystem::path ShardFolder(const std::filesystem::path& out, const Shard& shard);
// Returns the trials of a shard, ascending.
std::vector<int> TrialsOfShard(const Sweep& sweep, const Shard& shard);

// Options of a call of RunSweep.
struct SweepOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool resume = false;         // continue in a folder that holds finished trials
  bool retry_crashed = false;  // repeat the trials that crashed in an earlier call
  int picture_trials = 4;      // scenes 0 .. picture_trials - 1 of each configuration get pictures
  // Later scenes below this number get a small picture of each failed pick.
  int failure_picture_trials = 1000;
  std::vector<int> only_trials;  // ascending; empty = all of the shard
  Shard shard;
  MakeDoTrial make = PickingTrials();
  // Visits the numbers and switches.
  void Visit(SettingsVisitor& v);
};

// Progress of a sweep. All counts but done_before include trials of earlier calls.
struct RunState {
  int done = 0, total = 0;
  int done_before = 0;          // done in earlier calls
  int crashed = 0;              // among the done trials
  std::vector<Cluster> trials;  // success counts of each done trial that did not crash
  // Progress of the early stop, see eval/sweep/sweep_stop.h.
  std::string stop;
};

// Callbacks during a sweep or run; `stop` returns true to end it.
struct RunListener {
  std::function<void(const RunState& state)> on_trial;
  std::function<void(const std::string& line)> on_message;
  std::function<void(const std::string& line)> on_warning;  // another program failed
  std::function<bool()> stop;
};

// Result of RunSweep.
struct SweepReport {
  std::vector<ConfigurationSummary> configurations;  // empty for a shard
  bool interrupted = false;
  int finished = 0, total = 0;        // trials of this shard
  std::vector<CrashedTrial> crashed;  // crashed in this call
  // Wall times. "start", "trials" and "store" are sums over the workers. "progress" (handling of
  // finished trials) and "files" (summary files) are from the calling process.
  StageSeconds seconds;
};

// Runs all trials of a sweep or shard. A configuration with a stop_width ends early
// (eval/sweep/sweep_stop.h), unless `only_trials` names the trials. It forks worker processes; see
// RunInWorkers for the restrictions. Throws InputError for options out of range, unknown names, a
// broken model file, and a stop_width in a shard. Also throws it for an output folder that cannot
// be written, is in use, holds other results, or holds finished trials while `resume` is false.
// With a changed stop_width, it throws if the folder holds trials that the new width would not
// keep.
SweepReport RunSweep(const Sweep& sweep, const SweepOptions& options, const RunListener& listener);

// Returns the store head of a sweep with its results in `folder`.
StoreHead HeadOf(const Sweep& sweep, const std::filesystem::path& folder);

}  // namespace pickbed::eval
