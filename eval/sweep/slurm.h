#pragma once

// Runs a sweep as a Slurm job array. Each task computes one shard and continues where it was
// stopped, so it may be killed, requeued and submitted again at any time. OUT must be on a file
// system shared by all nodes.
//
//   OUT/slurm/job.sh               script of a task
//   OUT/slurm/job_id               id of the last submitted array
//   OUT/slurm/shard_3_of_8.log     output of a task

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/sweep/sweep.h"
#include "scenes/base/settings.h"

namespace pickbed::eval {

// Settings of the job array.
struct SlurmOptions {
  int shards = 8;
  std::string partition;  // empty = the cluster's default
  std::string time;     // time limit of a shard in sbatch format; empty = default of the partition
  std::string memory;   // memory of a shard in sbatch format; empty = default of the partition
  int cpus = 1;         // worker processes per shard
  std::string options;  // additional sbatch options, separated by spaces

  void Visit(SettingsVisitor& v);
  // Throws InputError for a text that could begin another line of the job script.
  void Validate() const;
};

// A sweep to be submitted.
struct SlurmJob {
  SlurmOptions options;
  std::filesystem::path program;  // the pickbed executable
  std::filesystem::path out;      // output folder of the sweep; holds sweep.yaml
  std::filesystem::path working_folder;
  std::string catalog;
  bool retry_crashed = false;
  int picture_trials = 0, failure_picture_trials = 0;  // as in SweepOptions
};

// Returns the content of OUT/slurm/job.sh.
std::string JobScript(const SlurmJob& job);

// Progress of one shard, read from its store.
struct ShardState {
  Shard shard;
  int done = 0, total = 0;        // trials
  int crashed = 0;                // among the done trials
  std::vector<Cluster> outcomes;  // success counts of each done trial that did not crash
  bool finished() const { return done == total; }
};
// Reads the stores of all shards. Throws InputError if one has other settings.
std::vector<ShardState> ShardStates(const Sweep& sweep, const std::filesystem::path& out,
                                    int shards);

// Callbacks while a job is followed.
struct SlurmListener {
  std::function<void(const RunState& state)> on_state;
  std::function<void(const std::string& line)> on_message;
  std::function<bool()> stop;
};

// Result of RunOnSlurm.
struct SlurmReport {
  std::string job_id;
  bool stopped = false;                 // the user stopped following the job; it continues
  std::vector<std::string> unfinished;  // such as "shard 3 of 8: TIMEOUT, 12 of 40 trials done"
};

// Submits the unfinished shards and follows the job until no task is left. If the array in
// OUT/slurm/job_id is still running, follows it instead. Throws InputError if Slurm is not
// installed, does not answer or refuses the job. Also throws it for several shards if a
// configuration has an early stop.
SlurmReport RunOnSlurm(const Sweep& sweep, const SlurmJob& job, const SlurmListener& listener);

}  // namespace pickbed::eval
