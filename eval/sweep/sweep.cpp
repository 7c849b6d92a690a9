#include "eval/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <optional>
#include <set>

#include "eval/runtime/results_folder.h"
#include "eval/sweep/sweep_spec.h"
#include "eval/sweep/sweep_stop.h"
#include "eval/sweep/trial_worker.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

constexpr int kRetriesAfterCrash = 1;

// Opens the store and closes it again, because workers must not be forked while it is open.
std::vector<int> FinishedTrials(const SweepOptions& options, const std::filesystem::path& folder,
                                const StoreHead& head) {
  ResultsStore store(folder, head);
  if (options.retry_crashed) store.ForgetCrashed();
  std::vector<int> finished = store.FinishedTrials();
  CheckInput(finished.empty() || options.resume,
             fmt::format("{} already has {} finished trials of this {}; resume it, or choose "
                         "another results folder",
                         folder.string(), finished.size(),
                         head.configurations.size() > 1 ? "sweep" : "scenario"));
  return finished;
}

void WriteSettingsFiles(const Sweep& sweep, const StoreHead& head,
                        const std::filesystem::path& out) {
  if (sweep.yaml.empty()) {
    WriteFileAtomically(out / kScenarioFile, head.configurations.front().settings);
    return;
  }
  WriteFileAtomically(out / kSweepFile, sweep.yaml);
  const std::filesystem::path folder = MakeConfigurationsFolder(out);
  for (const Configuration& configuration : sweep.configurations) {
    WriteFileAtomically(folder / ConfigurationFileName(configuration.number, configuration.name),
                        ScenarioText(configuration.spec, folder));
  }
}

// Returns the outcome of a trial that an earlier worker stored, but was killed before its reply.
// The store is open only for a moment, because workers must not be forked while it is open.
std::optional<Cluster> StoredOutcome(const StoreHead& head, const std::filesystem::path& folder,
                                     int trial) {
  return ResultsStore(folder, head).OutcomeOf(trial);
}

// Stores a trial that crashed its worker twice. This process opens the store only for a moment.
CrashedTrial NoteCrash(const Sweep& sweep, const StoreHead& head,
                       const std::filesystem::path& folder, int trial, const std::string& why) {
  const Configuration& configuration = ConfigurationOf(sweep, trial);
  const CrashedTrial crashed{trial, configuration.number,
                             BinIndex(trial - configuration.first_trial), configuration.spec.seed,
                             why};
  ResultsStore(folder, head).WriteCrashed(crashed);
  return crashed;
}

// The current call may request fewer trials than an earlier call has run.
void KeepEarlierTrials(const std::vector<int>& finished, Sweep& sweep) {
  if (sweep.configurations.size() > 1 || finished.empty()) return;
  Configuration& configuration = sweep.configurations.front();
  configuration.trials = configuration.spec.trials =
      std::max(configuration.trials, finished.back() + 1);
}

// Returns whether the trials in the folder were run with another stop width.
bool HasOtherStops(const Sweep& sweep, const std::filesystem::path& folder) {
  if (!StoredSettings(folder)) return false;
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  const std::vector<StoredConfiguration>& configurations = store.head().configurations;
  for (size_t i = 0; i < std::min(configurations.size(), sweep.configurations.size()); ++i) {
    const ScenarioSpec spec = ScenarioOfText(configurations[i].settings, folder, folder.string());
    if (spec.stop_width != sweep.configurations[i].spec.stop_width) return true;
  }
  return false;
}

// One call of RunSweep.
class SweepCall {
 public:
  SweepCall(const Sweep& sweep, const SweepOptions& options, const RunListener& listener);
  SweepReport Run();

 private:
  void ReadEarlier();   // reads the trials finished in earlier calls
  void CountEarlier();  // adds them to the progress
  WorkerPlan PlanOf(const StoreHead& head);
  void Note(int trial, const Cluster& outcome);
  void Count();
  // Removes trials that were running when their configuration ended.
  void ForgetNeedless();

  Sweep sweep_;
  const SweepOptions& options_;
  const RunListener& listener_;
  std::filesystem::path folder_;
  FolderLock lock_;
  std::optional<SweepStop> stop_;  // set if a configuration may end early
  std::vector<int> wanted_;        // trial numbers, ascending
  std::set<int> finished_;
  RunState state_;
  SweepReport report_;
};

SweepCall::SweepCall(const Sweep& sweep, const SweepOptions& options, const RunListener& listener)
    : sweep_(sweep),
      options_(options),
      listener_(listener),
      folder_(ShardFolder(options.out, options.shard)),
      lock_(folder_) {}

void SweepCall::ReadEarlier() {
  const bool may_stop = SweepStop(sweep_).enabled() && options_.only_trials.empty();
  const bool other_stops = may_stop && HasOtherStops(sweep_, folder_);
  const std::vector<int> finished = FinishedTrials(options_, folder_, HeadOf(sweep_, folder_));
  KeepEarlierTrials(finished, sweep_);
  finished_.insert(finished.begin(), finished.end());
  wanted_ =
      options_.only_trials.empty() ? TrialsOfShard(sweep_, options_.shard) : options_.only_trials;
  if (!may_stop) return;
  stop_.emplace(sweep_);
  const ResultsStore store = ResultsStore::OpenToRead(folder_);
  for (const CrashedTrial& crashed : store.Crashed()) stop_->Add(crashed.trial, {});
  store.ForEach([&](const TrialResult& result) { stop_->Add(result); });
  const auto lost =
      std::count_if(finished.begin(), finished.end(), [&](int t) { return !stop_->Counts(t); });
  CheckInput(
      !other_stops || lost == 0,
      fmt::format("{} has {} finished trials beyond the bin at which its configurations stop with "
                  "this stop_width; choose another results folder, or the former width",
                  folder_.string(), lost));
}

void SweepCall::Count() {
  const auto counts = [&](int trial) { return !stop_ || stop_->Counts(trial); };
  state_.done = static_cast<int>(std::count_if(finished_.begin(), finished_.end(), counts));
  state_.total = state_.done;
  for (const int trial : wanted_) state_.total += !finished_.contains(trial) && counts(trial);
}

void SweepCall::CountEarlier() {
  state_.done_before = state_.done;
  if (finished_.empty()) return;
  const ResultsStore store = ResultsStore::OpenToRead(folder_);
  const auto counts = [&](int trial) { return !stop_ || stop_->Counts(trial); };
  for (const CrashedTrial& crashed : store.Crashed()) state_.crashed += counts(crashed.trial);
  for (const auto& [trial, outcome] : store.Outcomes()) {
    if (counts(trial)) state_.trials.push_back(outcome);
  }
}

void SweepCall::Note(int trial, const Cluster& outcome) {
  const StageTimer timer(report_.seconds, "progress");
  finished_.insert(trial);
  ++state_.done;
  if (stop_) {
    const bool ends = stop_->Add(trial, outcome);
    if (ends || !stop_->Counts(trial)) Count();
    state_.stop = stop_->Note();
  }
  if (listener_.on_trial) listener_.on_trial(state_);
}

WorkerPlan SweepCall::PlanOf(const StoreHead& head) {
  WorkerPlan plan;
  for (const int trial : wanted_) {
    if (!finished_.contains(trial) && (!stop_ || stop_->Counts(trial))) plan.items.push_back(trial);
  }
  plan.jobs = options_.jobs;
  plan.retries = kRetriesAfterCrash;
  plan.group = [this](int trial) { return ConfigurationOf(sweep_, trial).number; };
  if (stop_) plan.needless = [this](int trial) { return !stop_->Counts(trial); };
  plan.start = [this, &head](const WorkerPlan::Say& say) {
    return StartWorker(sweep_, options_, head, folder_, say);
  };
  plan.on_done = [this](int item, const std::string& reply) {
    const Cluster trial = TakeReply(reply, report_.seconds);
    state_.trials.push_back(trial);
    Note(item, trial);
  };
  plan.on_lost = [this, &head](int trial, const std::string& why) {
    if (const auto stored = StoredOutcome(head, folder_, trial)) {
      state_.trials.push_back(*stored);
      Note(trial, *stored);
      return;
    }
    report_.crashed.push_back(NoteCrash(sweep_, head, folder_, trial, why));
    ++state_.crashed;
    Note(trial, {});
  };
  plan.on_message = listener_.on_message;
  plan.on_warning = listener_.on_warning;
  plan.stop = listener_.stop;
  return plan;
}

void SweepCall::ForgetNeedless() {
  ResultsStore store(folder_, HeadOf(sweep_, folder_));
  // Read from the store: a worker that was killed may have stored a trial without a reply.
  std::vector<int> needless = store.FinishedTrials();
  std::erase_if(needless, [&](int trial) { return stop_->Counts(trial); });
  if (needless.empty()) return;
  store.Forget(needless);
  for (const int trial : needless) std::filesystem::remove_all(PicturesOf(options_.out, trial));
  std::erase_if(report_.crashed,
                [&](const CrashedTrial& crashed) { return !stop_->Counts(crashed.trial); });
}

SweepReport SweepCall::Run() {
  // The store of a whole sweep checks its settings itself. The store of a shard may be the first in
  // the folder.
  if (options_.shard.count > 1) RequireNoOtherSweep(options_.out, sweep_.yaml);
  {
    const StageTimer timer(report_.seconds, "store");
    ReadEarlier();
  }
  const StoreHead head = HeadOf(sweep_, folder_);
  WriteSettingsFiles(sweep_, head, options_.out);
  Count();
  CountEarlier();
  report_.interrupted = RunInWorkers(PlanOf(head)).stopped;
  {
    const StageTimer timer(report_.seconds, "store");
    ResultsStore::Tidy(folder_);
    if (stop_) ForgetNeedless();
  }
  report_.finished = state_.done;
  report_.total = state_.total;
  if (options_.shard.count == 1) {
    const StageTimer timer(report_.seconds, "files");
    report_.configurations = WriteSweepFiles(options_.out);
  }
  return std::move(report_);
}

}  // namespace

const Configuration& ConfigurationOf(const Sweep& sweep, int trial) {
  const auto after = std::upper_bound(sweep.configurations.begin(), sweep.configurations.end(),
                                      trial, [](int number, const Configuration& configuration) {
                                        return number < configuration.first_trial;
                                      });
  return *std::prev(after);
}

Shard ParseShard(const std::string& text) {
  Shard shard;
  int used = 0;
  const int read = std::sscanf(text.c_str(), "%d/%d%n", &shard.index, &shard.count, &used);
  const bool ok = read == 2 && used == static_cast<int>(text.size()) && shard.index >= 1 &&
                  shard.index <= shard.count;
  CheckInput(ok, fmt::format("shard '{}': must be I/N with I from 1 to N, for example 3/8", text));
  return shard;
}

std::filesystem::path ShardFolder(const std::filesystem::path& out, const Shard& shard) {
  if (shard.count == 1) return out;
  return out / kShardsFolder / fmt::format("shard_{}_of_{}", shard.index, shard.count);
}

std::vector<int> TrialsOfShard(const Sweep& sweep, const Shard& shard) {
  int64_t total = 0;
  int scenes = 0;
  for (const Configuration& configuration : sweep.configurations) {
    total += configuration.trials;
    scenes = std::max(scenes, configuration.trials);
  }
  const int64_t from = total * (shard.index - 1) / shard.count;
  const int64_t to = total * shard.index / shard.count;
  std::vector<int> trials;
  int64_t number = 0;
  for (int scene = 0; scene < scenes; ++scene) {
    for (const Configuration& configuration : sweep.configurations) {
      if (scene >= configuration.trials) continue;
      if (number >= from && number < to) trials.push_back(configuration.first_trial + scene);
      ++number;
    }
  }
  std::sort(trials.begin(), trials.end());
  return trials;
}

StoreHead HeadOf(const Sweep& sweep, const std::filesystem::path& folder) {
  StoreHead head;
  for (const Configuration& configuration : sweep.configurations) {
    head.configurations.push_back({configuration.number, configuration.name,
                                   configuration.first_trial, configuration.trials,
                                   configuration.spec.seed, configuration.identity,
                                   ScenarioText(configuration.spec, folder)});
  }
  head.identity = SweepIdentity(head.configurations);
  // The number of trials of a run may be increased, and runs of an earlier version can be
  // continued.
  if (sweep.yaml.empty()) head.identity = sweep.configurations.front().identity;
  return head;
}

void Shard::Visit(SettingsVisitor& v) {
  v.Integer("count", count, {1, 1000000}, "number of shards");
  v.Integer("index", index, {1, static_cast<double>(std::max(1, count))}, "number of the shard");
}

void SweepOptions::Visit(SettingsVisitor& v) {
  v.Integer("jobs", jobs, {1, 100000}, "number of worker processes");
  v.Bool("resume", resume, "whether to continue in a folder that holds finished trials");
  v.Bool("retry_crashed", retry_crashed, "whether to repeat trials that crashed before");
  v.Integer("picture_trials", picture_trials, {0, 1e9},
            "number of scenes of each configuration with pictures");
  v.Integer("failure_picture_trials", failure_picture_trials, {0, 1e9},
            "scenes below this number get a picture of each failed pick");
  v.Group(
      "shard", [this](SettingsVisitor& g) { shard.Visit(g); }, "shard of the trials");
}

SweepReport RunSweep(const Sweep& given, const SweepOptions& options, const RunListener& listener) {
  CheckSettings("SweepOptions", options);
  if (options.shard.count > 1) RequireNoStop(given);
  return SweepCall(given, options, listener).Run();
}

}  // namespace pickbed::eval
