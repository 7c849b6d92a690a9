#include "eval/sweep/slurm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <regex>
#include <sstream>
#include <thread>

#include "eval/runtime/process.h"
#include "eval/runtime/results_folder.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/sweep_spec.h"
#include "eval/sweep/sweep_stop.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr std::chrono::milliseconds kAskEvery{2000};
constexpr std::chrono::milliseconds kCheckForStopEvery{100};
// Consecutive squeue failures; tolerates a restart of the controller.
constexpr int kMaxFailures = 30;

std::string Trimmed(const std::string& text) {
  const size_t from = text.find_first_not_of(" \t\r\n");
  if (from == std::string::npos) return "";
  return text.substr(from, text.find_last_not_of(" \t\r\n") - from + 1);
}

// Error messages have one line.
std::string OneLine(const std::string& text) {
  std::string line = Trimmed(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

// Returns the states of unfinished tasks by shard; empty if all have ended, nullopt if Slurm did
// not answer.
std::optional<std::map<int, std::string>> StatesInQueue(const std::string& job_id) {
  const ProgramOutput output =
      RunProgram({"squeue", "--noheader", "--array", "--jobs", job_id, "--format", "%K %T"});
  std::map<int, std::string> states;
  // Slurm forgets an array some time after it has ended.
  if (output.text.find("Invalid job id") != std::string::npos) return states;
  if (output.status != 0) return std::nullopt;
  std::istringstream lines(output.text);
  int shard = 0;
  for (std::string state; lines >> shard >> state;) {
    if (state != "COMPLETED" && state != "FAILED" && state != "CANCELLED" && state != "TIMEOUT" &&
        state != "NODE_FAIL" && state != "OUT_OF_MEMORY" && state != "BOOT_FAIL" &&
        state != "DEADLINE") {
      states[shard] = state;
    }
  }
  return states;
}

// Returns the final state of a task, if Slurm still knows it.
std::string EndOf(const std::string& job_id, int shard) {
  const ProgramOutput output =
      RunProgram({"scontrol", "show", "job", "--oneliner", fmt::format("{}_{}", job_id, shard)});
  const std::string key = "JobState=";
  const size_t at = output.text.find(key);
  if (output.status == 0 && at != std::string::npos) {
    const size_t from = at + key.size();
    return output.text.substr(from, output.text.find(' ', from) - from);
  }
  const ProgramOutput accounts =
      RunProgram({"sacct", "--noheader", "--allocations", "--parsable2", "--format=State", "--jobs",
                  fmt::format("{}_{}", job_id, shard)});
  return accounts.status == 0 && !Trimmed(accounts.text).empty() ? OneLine(accounts.text) : "ended";
}

void RequireSlurm() {
  for (const char* program : {"sbatch", "squeue", "scontrol"}) {
    CheckInput(HasProgram(program),
               fmt::format("there is no {} on this machine; log in to a node of the cluster, or "
                           "run the sweep here without Slurm",
                           program));
  }
}

std::string Submit(const Sweep& sweep, const SlurmJob& job, const std::vector<int>& shards) {
  const std::filesystem::path folder = job.out / kSlurmFolder;
  const std::filesystem::path script = folder / "job.sh";
  MakeFolder(folder);
  WriteFileAtomically(job.out / kSweepFile, sweep.yaml);
  WriteFileAtomically(script, JobScript(job));
  const ProgramOutput output = RunProgram(
      {"sbatch", "--parsable", fmt::format("--array={}", fmt::join(shards, ",")), script.string()});
  CheckInput(output.status == 0, fmt::format("Slurm refused the job: {} (its script is {})",
                                             OneLine(output.text), script.string()));
  // The output is "ID" or "ID;CLUSTER", possibly after warnings.
  const std::string text = Trimmed(output.text);
  const size_t line = text.find_last_of('\n');
  std::string id = line == std::string::npos ? text : text.substr(line + 1);
  id = id.substr(0, id.find(';'));
  WriteFileAtomically(folder / "job_id", id + "\n");
  return id;
}

// Returns the id of the last submitted array if it has unfinished tasks.
std::optional<std::string> RunningJob(const SlurmJob& job) {
  const std::filesystem::path file = job.out / kSlurmFolder / "job_id";
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const std::string id = Trimmed(ReadFileBytes(file));
  const auto states = StatesInQueue(id);
  CheckInput(states.has_value(), "squeue does not answer; is the Slurm controller running?");
  return states->empty() ? std::nullopt : std::optional(id);
}

RunState SumOf(const std::vector<ShardState>& shards) {
  RunState state;
  for (const ShardState& shard : shards) {
    state.done += shard.done;
    state.total += shard.total;
    state.crashed += shard.crashed;
    state.trials.insert(state.trials.end(), shard.outcomes.begin(), shard.outcomes.end());
  }
  return state;
}

std::string QueueText(const std::string& job_id, const std::map<int, std::string>& states) {
  std::map<std::string, int> counts;
  for (const auto& [shard, state] : states) ++counts[state];
  std::string text = "job " + job_id;
  for (const auto& [state, count] : counts) text += fmt::format(", {} {}", count, state);
  return text;
}

// Sleeps; returns true if the user requested a stop.
bool WaitOrStop(const SlurmListener& listener) {
  for (auto slept = kCheckForStopEvery; slept < kAskEvery; slept += kCheckForStopEvery) {
    if (listener.stop && listener.stop()) return true;
    std::this_thread::sleep_for(kCheckForStopEvery);
  }
  return false;
}

}  // namespace

void SlurmOptions::Visit(SettingsVisitor& v) {
  v.Integer("shards", shards, {1, 10000}, "number of shards, one per task of the job array");
  v.Text("partition", partition, {}, "partition of the cluster; empty = its default");
  v.Text("time", time, {},
         "time limit of a shard, for example 2:00:00; empty = default of the partition");
  v.Text("mem", memory, {}, "memory of a shard, for example 4G; empty = default of the partition");
  v.Integer("cpus", cpus, {1, 1024}, "number of worker processes of a shard");
  v.Text("options", options, {}, "further options of sbatch, separated by spaces");
}

void SlurmOptions::Validate() const {
  // A line break or a quote in one of them would begin another line of the job script.
  constexpr std::string_view kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+.,:/=@%[]";
  const auto check = [&](const char* key, const std::string& value, std::string_view allowed) {
    const size_t bad = value.find_first_not_of(allowed);
    if (bad == std::string::npos) return;
    const int code = static_cast<unsigned char>(value[bad]);
    throw InputError(
        fmt::format("slurm.{} has a character that is not allowed (code {}, number {}); "
                    "use letters, digits and {}",
                    key, code, bad + 1, allowed.substr(62)));
  };
  check("partition", partition, kAllowed);
  check("time", time, kAllowed);
  check("mem", memory, kAllowed);
  check("options", options, std::string(kAllowed) + " ");
  static const std::regex kTime("(\\d{1,5}-)?\\d{1,8}(:\\d{1,2}){0,2}|UNLIMITED",
                                std::regex_constants::icase);
  CheckInput(
      time.empty() || std::regex_match(time, kTime),
      fmt::format("slurm.time = {}: must be minutes, or [DAYS-]HOURS:MINUTES:SECONDS", time));
  static const std::regex kMemory("\\d{1,9}[KMGT]?B?", std::regex_constants::icase);
  CheckInput(memory.empty() || std::regex_match(memory, kMemory),
             fmt::format("slurm.mem = {}: must be a number with K, M, G or T, such as 4G", memory));
}

std::string JobScript(const SlurmJob& job) {
  CheckSettings("SlurmOptions", job.options);
  job.options.Validate();
  const SlurmOptions& o = job.options;
  const std::string log =
      (job.out / kSlurmFolder / fmt::format("shard_%a_of_{}.log", o.shards)).string();
  CheckInput(log.find('\n') == std::string::npos,
             "the results folder has a line break in its name; choose another name with --out");
  std::string text = "#!/bin/sh\n#SBATCH --job-name=pickbed\n#SBATCH --requeue\n";
  const auto option = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) text += fmt::format("#SBATCH --{}={}\n", name, value);
  };
  option("output", Quoted(log));
  option("open-mode", "append");  // a requeued task appends to its log
  option("cpus-per-task", std::to_string(o.cpus));
  option("partition", o.partition);
  option("time", o.time);
  option("mem", o.memory);
  std::istringstream more(o.options);
  for (std::string word; more >> word;) text += "#SBATCH " + word + "\n";
  text += fmt::format(
      "cd {} || exit 1\nexec {} sweep {} --out {} --catalog {} \\\n  --pictures {} "
      "--failure-pictures {} --shard \"$SLURM_ARRAY_TASK_ID/{}\" --jobs {} --resume{}\n",
      Quoted(job.working_folder.string()), Quoted(job.program.string()),
      Quoted((job.out / kSweepFile).string()), Quoted(job.out.string()), Quoted(job.catalog),
      job.picture_trials, job.failure_picture_trials, o.shards, o.cpus,
      job.retry_crashed ? " --retry-crashed" : "");
  return text;
}

std::vector<ShardState> ShardStates(const Sweep& sweep, const std::filesystem::path& out,
                                    int shards) {
  std::vector<ShardState> states;
  for (int i = 1; i <= shards; ++i) {
    ShardState& state = states.emplace_back();
    state.shard = {i, shards};
    state.total = static_cast<int>(TrialsOfShard(sweep, state.shard).size());
    const std::filesystem::path folder = ShardFolder(out, state.shard);
    const std::optional<std::string> stored = StoredSettings(folder);
    if (!stored) continue;
    CheckInput(*stored == HeadOf(sweep, folder).identity || stored->empty(),
               fmt::format("{} has results of other settings; choose another results folder",
                           folder.string()));
    const ResultsStore store = ResultsStore::OpenToRead(folder, StoreChecks::kVersion);
    state.done = static_cast<int>(store.FinishedTrials().size());
    state.crashed = static_cast<int>(store.Crashed().size());
    for (const auto& [trial, outcome] : store.Outcomes()) state.outcomes.push_back(outcome);
  }
  return states;
}

SlurmReport RunOnSlurm(const Sweep& sweep, const SlurmJob& job, const SlurmListener& listener) {
  CheckSettings("SlurmOptions", job.options);
  if (job.options.shards > 1) RequireNoStop(sweep);
  RequireSlurm();
  RequireNoOtherSweep(job.out, sweep.yaml);
  SlurmReport report;
  const auto states = [&] { return ShardStates(sweep, job.out, job.options.shards); };
  const int done_before = SumOf(states()).done;
  if (const auto running = RunningJob(job)) {
    report.job_id = *running;
  } else {
    std::vector<int> open;
    for (const ShardState& shard : states()) {
      if (!shard.finished() || job.retry_crashed) open.push_back(shard.shard.index);
    }
    if (open.empty()) return report;
    report.job_id = Submit(sweep, job, open);
  }
  RunState state;
  for (int failures = 0;;) {
    const auto queue = StatesInQueue(report.job_id);
    failures = queue ? 0 : failures + 1;
    CheckInput(
        failures < kMaxFailures,
        fmt::format(
            "squeue does not answer; job {} may still run, repeat the same command to follow it",
            report.job_id));
    // A store may be locked while its shard writes, or after a task was killed. It is read again
    // later, and once more when all tasks have ended.
    try {
      state = SumOf(states());
    } catch (const InputError&) {
    }
    state.done_before = done_before;
    if (listener.on_message && queue) listener.on_message(QueueText(report.job_id, *queue));
    if (listener.on_state) listener.on_state(state);
    if (queue && queue->empty()) break;
    if (WaitOrStop(listener)) {
      report.stopped = true;
      return report;
    }
  }
  for (const ShardState& shard : states()) {
    if (shard.finished()) continue;
    report.unfinished.push_back(fmt::format(
        "shard {} of {}: {}, {} of {} trials done", shard.shard.index, shard.shard.count,
        EndOf(report.job_id, shard.shard.index), shard.done, shard.total));
  }
  return report;
}

}  // namespace pickbed::eval
