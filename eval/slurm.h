#pragma once

// A sweep as a job array of Slurm: each task is a shard that goes on where it was stopped, so that
// it may be killed, requeued and submitted again at any time. OUT must lie where all nodes see it.
//
//   OUT/slurm/job.sh               what a task runs
//   OUT/slurm/job_id               of the array submitted last
//   OUT/slurm/shard_3_of_8.log     what the task printed

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/sweep.h"
#include "scenes/settings.h"

namespace pickbed {

struct SlurmOptions {
  int shards = 8;
  std::string partition;  // empty = the cluster's default
  std::string time;       // limit of a shard, as sbatch takes it; empty = the partition's
  std::string memory;     // of a shard, as sbatch takes it; empty = the partition's
  int cpus = 1;           // worker processes of a shard
  std::string options;    // further ones for sbatch, separated by spaces

  void Visit(SettingsVisitor& v);
};

struct SlurmJob {
  SlurmOptions options;
  std::filesystem::path program;  // pickbed itself
  std::filesystem::path out;      // of the sweep; holds sweep.yaml
  std::filesystem::path working_folder;
  std::string catalog;
  bool retry_crashed = false;
  int picture_trials = 0, lost_picture_trials = 0;  // as in SweepOptions
};

// OUT/slurm/job.sh
std::string JobScript(const SlurmJob& job);

// What the store of each shard holds by now.
struct ShardState {
  Shard shard;
  int done = 0, total = 0;        // trials
  int crashed = 0;                // of those that are done
  std::vector<Cluster> outcomes;  // successes of attempts of each of the others
  bool finished() const { return done == total; }
};
std::vector<ShardState> ShardStates(const Sweep& sweep, const std::filesystem::path& out,
                                    int shards);

struct SlurmListener {
  std::function<void(const RunState& state)> on_state;
  std::function<void(const std::string& line)> on_message;
  std::function<bool()> stop;
};

struct SlurmReport {
  std::string job_id;
  bool stopped = false;                 // no longer followed; the job goes on
  std::vector<std::string> unfinished;  // "shard 3 of 8: TIMEOUT, 12 of 40 trials done"
};

// Submits those shards that are not finished, or follows the array that OUT/slurm/job_id names
// where that still runs, until no task is left. Throws InputError where Slurm is absent, cannot be
// reached, or refuses the job.
SlurmReport RunOnSlurm(const Sweep& sweep, const SlurmJob& job, const SlurmListener& listener);

}  // namespace pickbed
