#include "eval/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <memory>

#include "eval/folder_lock.h"
#include "eval/pictures.h"
#include "eval/scenario_text.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/random.h"

namespace pickbed {
namespace {

constexpr std::chrono::seconds kSayEvery{2};
constexpr int kTriesAfterACrash = 1;

const SweepPoint& PointOf(const Sweep& sweep, int trial) {
  const auto after = std::upper_bound(
      sweep.points.begin(), sweep.points.end(), trial,
      [](int number, const SweepPoint& point) { return number < point.first_trial; });
  return *std::prev(after);
}

// What a worker tells of a finished trial: "attempts successes".
std::string ReplyOf(const TrialResult& result) {
  const auto attempts =
      std::count_if(result.picks.begin(), result.picks.end(),
                    [](const PickRecord& pick) { return pick.grasp.has_value(); });
  const auto successes = std::count_if(
      result.picks.begin(), result.picks.end(),
      [](const PickRecord& pick) { return pick.grasp.has_value() && pick.loss == Loss::kNone; });
  return fmt::format("{} {}", attempts, successes);
}

// A worker's: what it made for the point that it is at, and where it writes.
struct Bench {
  ResultsStore store;
  const SweepPoint* point = nullptr;
  DoTrial do_trial;
};

std::string DoItem(Bench& bench, const SweepPoint& point, const SweepOptions& options, int trial,
                   const WorkerPlan::Say& say) {
  if (bench.point != &point) {
    bench.do_trial = nullptr;  // one point's meshes and networks at a time
    bench.do_trial = options.make(point, say);
    bench.point = &point;
  }
  const int scene = trial - point.first_trial;
  std::filesystem::path pictures;
  if (scene < options.picture_trials) {
    pictures = options.out / "pictures" / fmt::format("trial_{:04}", trial);
  }
  TrialResult result = bench.do_trial(scene, pictures);
  result.trial = trial;
  result.scene = scene;
  result.point = point.point;
  bench.store.Write(result);
  return ReplyOf(result);
}

WorkerPlan::DoItem StartWorker(const Sweep& sweep, const SweepOptions& options,
                               const StoreHead& head, const std::filesystem::path& folder,
                               const WorkerPlan::Say& say) {
  auto bench = std::make_shared<Bench>(Bench{ResultsStore(folder, head), nullptr, nullptr});
  if (sweep.points.size() ==
      1) {  // else a worker is told only with its first trial where it starts
    bench->point = &sweep.points.front();
    bench->do_trial = options.make(*bench->point, say);
  }
  return [bench, &sweep, &options, say](int trial) {
    return DoItem(*bench, PointOf(sweep, trial), options, trial, say);
  };
}

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

std::vector<int> TrialsToDo(const Sweep& sweep, const SweepOptions& options,
                            const std::vector<int>& finished) {
  const std::vector<int> wanted =
      options.only_trials.empty() ? TrialsOfShard(sweep, options.shard) : options.only_trials;
  std::vector<int> to_do;
  std::set_difference(wanted.begin(), wanted.end(), finished.begin(), finished.end(),
                      std::back_inserter(to_do));
  return to_do;
}

}  // namespace

MakeDoTrial PickingTrials(const TrialOptions& trial_options) {
  return [trial_options](const SweepPoint& point, const WorkerPlan::Say& say) -> DoTrial {
    using Clock = std::chrono::steady_clock;
    const auto on_progress = [say, said = Clock::time_point()](std::string_view what,
                                                               double share) mutable {
      if (Clock::now() - said < kSayEvery) return;
      said = Clock::now();
      say(fmt::format("{}: {:.0f} %", what, 100 * share));
    };
    auto runner =
        std::make_shared<TrialRunner>(point.spec, point.objects, on_progress, trial_options);
    return [runner](int scene, const std::filesystem::path& folder) {
      if (folder.empty()) return runner->Run(scene);
      PickPictures pictures(folder);
      return runner->Run(scene, &pictures);
    };
  };
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
  Sweep sweep = given;
  const std::filesystem::path folder = ShardFolder(options.out, options.shard);
  const FolderLock lock(folder);
  const std::vector<int> finished = FinishedTrials(options, folder, HeadOf(sweep, folder));
  KeepEarlierTrials(finished, sweep);
  const StoreHead head = HeadOf(sweep, folder);
  WriteSettingsFiles(sweep, head, options.out);

  WorkerPlan plan;
  plan.items = TrialsToDo(sweep, options, finished);
  plan.jobs = options.jobs;
  plan.retries = kTriesAfterACrash;
  plan.group = [&](int trial) { return PointOf(sweep, trial).point; };
  plan.start = [&](const WorkerPlan::Say& say) {
    return StartWorker(sweep, options, head, folder, say);
  };
  SweepReport report;
  RunState state;
  state.done = state.done_before = static_cast<int>(finished.size());
  state.total = state.done + static_cast<int>(plan.items.size());
  const auto tell = [&] {
    ++state.done;
    if (listener.on_trial) listener.on_trial(state);
  };
  plan.on_done = [&](int, const std::string& reply) {
    Cluster trial;
    std::sscanf(reply.c_str(), "%d %d", &trial.tries, &trial.hits);
    state.trials.push_back(trial);
    state.attempts += trial.tries;
    state.successes += trial.hits;
    tell();
  };
  plan.on_lost = [&](int trial, const std::string& why) {
    report.crashed.push_back(NoteCrash(sweep, head, folder, trial, why));
    ++state.crashed;
    tell();
  };
  plan.on_message = listener.on_message;
  plan.stop = listener.stop;
  report.interrupted = RunInWorkers(plan).stopped;
  report.finished = state.done;
  report.total = state.total;
  if (options.shard.count == 1) report.points = WriteSweepFiles(options.out);
  return report;
}

}  // namespace pickbed
