#pragma once

// A grid of settings run over worker processes into one results folder; a run is a sweep of one
// point.
//
//   OUT/results.sqlite      everything, see eval/results_store.h
//   OUT/shards/shard_1_of_8/results.sqlite    instead, of a shard; `pickbed merge` joins them
//   OUT/scenario.yaml       the settings in force, of a run
//   OUT/sweep.yaml, OUT/points/00_NAME.yaml   the same of a sweep and of each of its points
//   OUT/lock                held while something writes here
//   what eval/sweep_files.h says, made from the store at the end
//
// All but times are the same bytes for any number of workers and shards.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/results_store.h"
#include "eval/sweep_files.h"
#include "eval/workers.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

// One set of settings; owns trials [first_trial, first_trial + trials) of the store, of scenes 0,
// 1, ...
struct SweepPoint {
  int point = 0;
  std::string name;  // "estimator.name=ppf,sensor=ideal", empty in a run
  ScenarioSpec spec;
  ObjectSet objects;
  std::string identity;  // see RunIdentity in eval/run.h
  int first_trial = 0;
  int trials = 0;
};

struct Sweep {
  std::vector<SweepPoint> points;
  std::string yaml;  // of OUT/sweep.yaml; empty: a run
};
// The one that owns a trial.
const SweepPoint& PointOf(const Sweep& sweep, int trial);

// Which pictures a trial is to leave, see eval/pictures.h.
enum class PicturesWanted { kNone, kOfLostPicks, kAll };
struct PictureOrder {
  PicturesWanted wanted = PicturesWanted::kNone;
  std::filesystem::path folder;
};
// What does the trials of one point. It is called in a worker with the number of a scene; trial and
// point are filled in by the sweep.
using DoTrial = std::function<TrialResult(int scene, const PictureOrder& pictures)>;
// Makes that in a worker, which does many trials of a point one after the other. Throws InputError
// for what the settings name and is not there.
using MakeDoTrial = std::function<DoTrial(const SweepPoint& point, const WorkerPlan::Say& say)>;
// Drop, look, estimate, pick.
MakeDoTrial PickingTrials(const TrialOptions& options = {});

// Part `index` (1 .. count) of a sweep's trials, in the order of their scenes with all points of
// each, so that what is compared lies in one shard; but a scene at the border of two has points in
// both.
struct Shard {
  int index = 1;
  int count = 1;
};
// Of "3/8". Throws InputError.
Shard ParseShard(const std::string& text);
std::filesystem::path ShardFolder(const std::filesystem::path& out, const Shard& shard);
// Trials of a shard, ascending.
std::vector<int> TrialsOfShard(const Sweep& sweep, const Shard& shard);

struct SweepOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool resume = false;             // go on in a folder that holds finished trials
  bool retry_crashed = false;      // those of an earlier call are tried again
  int picture_trials = 4;          // scenes 0 .. picture_trials - 1 of each point get pictures
  int lost_picture_trials = 1000;  // later ones below this get a small one of each lost pick
  std::vector<int> only_trials;    // ascending; empty = all of the shard
  Shard shard;
  MakeDoTrial make = PickingTrials();
};

// How far a sweep is.
struct RunState {
  int done = 0, total = 0;      // trials, with those of an earlier run, as all but done_before
  int done_before = 0;          // of an earlier run
  int crashed = 0;              // of those that are done
  std::vector<Cluster> trials;  // successes of attempts of each of the others
  std::string stop;             // how near points are to their early end, see eval/sweep_stop.h
};

struct RunListener {
  std::function<void(const RunState& state)> on_trial;
  std::function<void(const std::string& line)> on_message;
  std::function<bool()> stop;
};

struct SweepReport {
  std::vector<PointSummary> points;  // none of a shard
  bool interrupted = false;
  int finished = 0, total = 0;        // trials of this shard
  std::vector<CrashedTrial> crashed;  // of this call
  // Where its wall time went: "start", "trials" and "store" are sums over the workers; "progress",
  // what follows the end of a trial, and "files", statistics and all, are of the calling process.
  StageSeconds seconds;
};

// A point with a stop_width ends early (eval/sweep_stop.h), but where `only_trials` names the
// trials. Throws InputError for unknown names, a broken model, a stop_width in a shard, and a
// folder that cannot be written, is in use, holds other results, holds finished trials when
// `resume` is not set, or more of them than another stop_width would keep. Forks, see
// eval/workers.h.
SweepReport RunSweep(const Sweep& sweep, const SweepOptions& options, const RunListener& listener);

// The store's head of a sweep whose results lie in `folder`.
StoreHead HeadOf(const Sweep& sweep, const std::filesystem::path& folder);

}  // namespace pickbed
