#include "eval/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <optional>
#include <set>

#include "eval/folder_lock.h"
#include "eval/scenario_text.h"
#include "eval/sweep_folder.h"
#include "eval/sweep_stop.h"
#include "eval/sweep_worker_impl.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/random.h"

namespace pickbed {
namespace {

constexpr int kTriesAfterACrash = 1;

// Opens the store, and closes it again before workers are forked.
std::vector<int> FinishedTrials(const SweepOptions& options, const std::filesystem::path& folder,
                                const StoreHead& head) {
  ResultsStore store(folder, head);
  if (options.retry_crashed) store.ForgetCrashed();
  std::vector<int> finished = store.FinishedTrials();
  CheckInput(
      finished.empty() || options.resume,
      fmt::format("{} already holds {} finished trials of this {}; pass --resume to go on "
                  "with it, or choose another folder with --out",
                  folder.string(), finished.size(), head.points.size() > 1 ? "sweep" : "scenario"));
  return finished;
}

void WriteSettingsFiles(const Sweep& sweep, const StoreHead& head,
                        const std::filesystem::path& out) {
  if (sweep.yaml.empty()) {
    WriteFileAtomically(out / "scenario.yaml", head.points.front().settings);
    return;
  }
  WriteFileAtomically(out / "sweep.yaml", sweep.yaml);
  const std::filesystem::path folder = out / "points";
  std::filesystem::create_directories(folder);
  for (const SweepPoint& point : sweep.points) {
    WriteFileAtomically(folder / PointFileName(point.point, point.name),
                        ScenarioText(point.spec, folder));
  }
}

// Writes down a trial that ended its worker twice. No worker's: the store is open for a moment.
CrashedTrial NoteCrash(const Sweep& sweep, const StoreHead& head,
                       const std::filesystem::path& folder, int trial, const std::string& why) {
  const SweepPoint& point = PointOf(sweep, trial);
  const CrashedTrial crashed{trial, point.point, trial - point.first_trial, point.spec.seed, why};
  ResultsStore(folder, head).WriteCrashed(crashed);
  return crashed;
}

// Fewer trials may be asked for now than were run before.
void KeepEarlierTrials(const std::vector<int>& finished, Sweep& sweep) {
  if (sweep.points.size() > 1 || finished.empty()) return;
  SweepPoint& point = sweep.points.front();
  point.trials = point.spec.trials = std::max(point.trials, finished.back() + 1);
}

// Settings that the folder's trials were done with may say another width.
bool HasOtherStops(const Sweep& sweep, const std::filesystem::path& folder) {
  if (!StoredSettings(folder)) return false;
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  const std::vector<StoredPoint>& points = store.head().points;
  for (size_t i = 0; i < std::min(points.size(), sweep.points.size()); ++i) {
    const ScenarioSpec spec = ScenarioOfText(points[i].settings, folder, folder.string());
    if (spec.stop_width != sweep.points[i].spec.stop_width) return true;
  }
  return false;
}

// One call of RunSweep.
class SweepCall {
 public:
  SweepCall(const Sweep& sweep, const SweepOptions& options, const RunListener& listener);
  SweepReport Run();

 private:
  void ReadEarlier();   // what an earlier call finished
  void CountEarlier();  // of that, what progress tells
  WorkerPlan PlanOf(const StoreHead& head);
  void Note(int trial, const Cluster& outcome);
  void Count();
  void ForgetNeedless();  // what was under way when its point ended

  Sweep sweep_;
  const SweepOptions& options_;
  const RunListener& listener_;
  std::filesystem::path folder_;
  FolderLock lock_;
  std::optional<SweepStop> stop_;  // where one of the points may end early
  std::vector<int> wanted_;        // trials, ascending
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
  CheckInput(!other_stops || lost == 0,
             fmt::format("{} holds {} finished trials beyond where its points would stop with this "
                         "stop_width; choose another folder with --out, or the width it had",
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
  state_.crashed = static_cast<int>(store.Crashed().size());
  for (const auto& [trial, outcome] : store.Outcomes()) {
    if (!stop_ || stop_->Counts(trial)) state_.trials.push_back(outcome);
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
  plan.retries = kTriesAfterACrash;
  plan.group = [this](int trial) { return PointOf(sweep_, trial).point; };
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
    report_.crashed.push_back(NoteCrash(sweep_, head, folder_, trial, why));
    ++state_.crashed;
    Note(trial, {});
  };
  plan.on_message = listener_.on_message;
  plan.stop = listener_.stop;
  return plan;
}

void SweepCall::ForgetNeedless() {
  std::vector<int> needless;
  for (const int trial : finished_) {
    if (!stop_->Counts(trial)) needless.push_back(trial);
  }
  if (needless.empty()) return;
  ResultsStore(folder_, HeadOf(sweep_, folder_)).Forget(needless);
  for (const int trial : needless) std::filesystem::remove_all(PicturesOf(options_.out, trial));
  std::erase_if(report_.crashed,
                [&](const CrashedTrial& crashed) { return !stop_->Counts(crashed.trial); });
}

SweepReport SweepCall::Run() {
  // The store of the whole refuses other settings itself; that of a shard may be the first.
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
    report_.points = WriteSweepFiles(options_.out);
  }
  return std::move(report_);
}

}  // namespace

const SweepPoint& PointOf(const Sweep& sweep, int trial) {
  const auto after = std::upper_bound(
      sweep.points.begin(), sweep.points.end(), trial,
      [](int number, const SweepPoint& point) { return number < point.first_trial; });
  return *std::prev(after);
}

Shard ParseShard(const std::string& text) {
  Shard shard;
  int used = 0;
  const int read = std::sscanf(text.c_str(), "%d/%d%n", &shard.index, &shard.count, &used);
  const bool ok = read == 2 && used == static_cast<int>(text.size()) && shard.index >= 1 &&
                  shard.index <= shard.count;
  CheckInput(ok, fmt::format("--shard {}: must be I/N with I from 1 to N, such as 3/8", text));
  return shard;
}

std::filesystem::path ShardFolder(const std::filesystem::path& out, const Shard& shard) {
  if (shard.count == 1) return out;
  return out / "shards" / fmt::format("shard_{}_of_{}", shard.index, shard.count);
}

std::vector<int> TrialsOfShard(const Sweep& sweep, const Shard& shard) {
  int64_t total = 0;
  int scenes = 0;
  for (const SweepPoint& point : sweep.points) {
    total += point.trials;
    scenes = std::max(scenes, point.trials);
  }
  const int64_t from = total * (shard.index - 1) / shard.count;
  const int64_t to = total * shard.index / shard.count;
  std::vector<int> trials;
  int64_t number = 0;
  for (int scene = 0; scene < scenes; ++scene) {
    for (const SweepPoint& point : sweep.points) {
      if (scene >= point.trials) continue;
      if (number >= from && number < to) trials.push_back(point.first_trial + scene);
      ++number;
    }
  }
  std::sort(trials.begin(), trials.end());
  return trials;
}

StoreHead HeadOf(const Sweep& sweep, const std::filesystem::path& folder) {
  StoreHead head;
  for (const SweepPoint& point : sweep.points) {
    head.points.push_back({point.point, point.name, point.first_trial, point.trials,
                           point.spec.seed, point.identity, ScenarioText(point.spec, folder)});
    head.identity +=
        fmt::format("point {} has {} trials {:016x}: {}\n", point.point, point.trials,
                    HashBytes(point.identity.data(), point.identity.size()), point.name);
  }
  // A run may be made longer, and one of an earlier version can go on.
  if (sweep.yaml.empty()) head.identity = sweep.points.front().identity;
  return head;
}

SweepReport RunSweep(const Sweep& given, const SweepOptions& options, const RunListener& listener) {
  if (options.shard.count > 1) RequireNoStop(given);
  return SweepCall(given, options, listener).Run();
}

}  // namespace pickbed
