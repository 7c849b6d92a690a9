#include "eval/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <memory>
#include <numeric>

#include "eval/oracle.h"
#include "eval/pictures.h"
#include "eval/results_store.h"
#include "grasp/gripper.h"
#include "grasp/plan.h"
#include "grasp/success_rules.h"
#include "perception/pose_estimator.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/random.h"
#include "sim/sensor_profile.h"

namespace pickbed {
namespace {

constexpr std::chrono::seconds kSayEvery{2};

std::string SettingsText(ScenarioSpec spec) {
  return WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
}

// Paths of meshes made relative to the results folder, so that its scenario.yaml can be run again.
std::string ScenarioText(ScenarioSpec spec, const std::filesystem::path& out) {
  if (!spec.bin.mesh.empty()) {
    spec.bin.mesh = std::filesystem::relative(spec.folder / spec.bin.mesh, out).string();
  }
  for (PartSpec& part : spec.objects) {
    if (!part.mesh.empty()) {
      part.mesh = std::filesystem::relative(spec.folder / part.mesh, out).string();
    }
  }
  return SettingsText(spec);
}

// Opens the store, and closes it again before workers are forked.
std::vector<int> FinishedTrials(const RunOptions& options, const std::string& identity) {
  const std::vector<int> finished = ResultsStore(options.out, identity).FinishedTrials();
  CheckInput(finished.empty() || options.resume,
             fmt::format("{} already holds {} finished trials of this scenario; pass --resume to "
                         "go on with it, or choose another folder with --out",
                         options.out.string(), finished.size()));
  return finished;
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

WorkerPlan::DoItem StartWorker(const ScenarioSpec& spec, const ObjectSet& objects,
                               const RunOptions& options, const std::string& identity,
                               const WorkerPlan::Say& say) {
  using Clock = std::chrono::steady_clock;
  const auto on_progress = [say, said = Clock::time_point()](std::string_view what,
                                                             double share) mutable {
    if (Clock::now() - said < kSayEvery) return;
    said = Clock::now();
    say(fmt::format("{}: {:.0f} %", what, 100 * share));
  };
  TrialOptions trial_options;
  trial_options.truth = options.truth;
  auto runner = std::make_shared<TrialRunner>(spec, objects, on_progress, trial_options);
  auto store = std::make_shared<ResultsStore>(options.out, identity);
  return [runner, store, options](int trial) {
    PickPictures pictures(options.out / "pictures" / fmt::format("trial_{:04}", trial));
    const TrialResult result =
        runner->Run(trial, trial < options.picture_trials ? &pictures : nullptr);
    store->Write(result);
    return ReplyOf(result);
  };
}

void WriteReports(const std::vector<TrialResult>& trials, const ObjectSet& objects,
                  const RunSummary& summary, const RunOptions& options) {
  const std::filesystem::path& out = options.out;
  WriteFileAtomically(out / "summary.json", SummaryJson(summary));
  WriteFileAtomically(out / "trials.csv", TrialsCsv(trials));
  WriteFileAtomically(out / "picks.csv", PicksCsv(trials, objects, options.tolerance));
  WriteFileAtomically(out / "parts.csv", PartsCsv(trials, objects));
  WriteFileAtomically(out / "timings.csv", TimingsCsv(trials, summary.cycle));
  if (options.tolerance.empty()) return;
  WriteFileAtomically(out / "pick_chances.csv", PickChancesCsv(trials, objects, options.tolerance));
}

// All of a part that a trial depends on.
uint64_t PartHash(const ObjectModel& part) {
  std::vector<double> numbers{part.mass.mass_kg, part.friction};
  const auto add = [&](const auto& values) {
    numbers.insert(numbers.end(), values.data(), values.data() + values.size());
  };
  add(part.mass.com_O);
  add(part.mass.inertia_com_O);
  for (const Pose& X_OO : part.symmetries_O.discrete_O) add(X_OO.matrix());
  for (const ContinuousSymmetry& axis : part.symmetries_O.continuous_O) {
    add(axis.axis_O);
    add(axis.offset_O);
  }
  for (const ConvexPiece& piece : part.convex_parts_O) {
    for (const Eigen::Vector3d& p_O : piece.vertices_O) add(p_O);
  }
  return HashBytes(numbers.data(), numbers.size() * sizeof(double), part.mesh_hash);
}

std::string FedText(const TruthStages& truth) {
  return fmt::format("# truth for: sense {}, detection {}, pose {}, refinement {}, grasp {}\n",
                     truth.sense, truth.detection, truth.pose, truth.refinement, truth.grasp);
}

}  // namespace

std::string RunIdentity(const ScenarioSpec& spec, const ObjectSet& objects,
                        const TruthStages& truth) {
  ScenarioSpec same_for_all = spec;
  same_for_all.trials = 1;
  same_for_all.cycle = {};
  // Their contents stand below; where they lie is no matter.
  same_for_all.bin.mesh.clear();
  for (PartSpec& part : same_for_all.objects) part.mesh.clear();
  std::string text = SettingsText(same_for_all);
  BlameKey(spec, "estimator.name", [&] { RequireEstimator(spec.estimator.name); });
  BlameKey(spec, "policy.ranking", [&] { RankingNamed(spec.policy.ranking); });
  BlameKey(spec, "policy.success", [&] { DecidingRule(spec.policy.success); });
  // Files that the settings only name.
  GripperSpec gripper = BlameKey(spec, "gripper", [&] { return LoadGripper(spec.gripper); });
  BlameKey(spec, "gripper", [&] {
    RequireFitsBin(gripper, BinOf(spec));
    for (const auto& object : objects) RequireCanCarry(gripper, *object);
  });
  SensorProfile sensor = BlameKey(spec, "sensor", [&] { return LoadSensorProfile(spec.sensor); });
  text += WriteSettings([&](SettingsVisitor& v) { gripper.Visit(v); });
  text += WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); });
  for (const auto& object : objects) {
    text += fmt::format("# part {} is {:016x}\n", object->name, PartHash(*object));
  }
  if (!spec.bin.mesh.empty()) {
    const std::string bytes = ReadFileBytes(spec.folder / spec.bin.mesh);
    text += fmt::format("# bin {:016x}\n", HashBytes(bytes.data(), bytes.size()));
  }
  for (const EstimatorRow& row : EstimatorTable()) {
    if (spec.estimator.name != row.name || row.model_file == nullptr) continue;
    const std::filesystem::path file = row.model_file(spec.estimator);
    if (!std::filesystem::exists(file)) continue;  // the estimator says best what to do
    const std::string bytes = ReadFileBytes(file);
    text += fmt::format("# model {:016x}\n", HashBytes(bytes.data(), bytes.size()));
  }
  if (truth != TruthStages()) text += FedText(truth);
  return text;
}

TruthStages TruthIn(const std::string& identity) {
  for (const OracleRow& row : OracleTable()) {
    if (identity.ends_with(FedText(row.truth))) return row.truth;
  }
  return {};
}

RunReport RunScenario(const ScenarioSpec& spec, const ObjectSet& objects, const RunOptions& options,
                      const RunListener& listener) {
  const std::string identity = RunIdentity(spec, objects, options.truth);
  const std::vector<int> finished = FinishedTrials(options, identity);
  ScenarioSpec all_trials = spec;  // fewer may be asked for now than were run before
  if (!finished.empty()) all_trials.trials = std::max(spec.trials, finished.back() + 1);
  WriteFileAtomically(options.out / "scenario.yaml", ScenarioText(all_trials, options.out));

  WorkerPlan plan;
  std::vector<int> wanted = options.only_trials;
  if (wanted.empty()) {
    wanted.resize(spec.trials);
    std::iota(wanted.begin(), wanted.end(), 0);
  }
  std::set_difference(wanted.begin(), wanted.end(), finished.begin(), finished.end(),
                      std::back_inserter(plan.items));
  RunState state;
  state.done = state.done_before = static_cast<int>(finished.size());
  state.total = state.done + static_cast<int>(plan.items.size());
  plan.jobs = options.jobs;
  plan.start = [&](const WorkerPlan::Say& say) {
    return StartWorker(spec, objects, options, identity, say);
  };
  plan.on_done = [&](int, const std::string& reply) {
    int attempts = 0, successes = 0;
    std::sscanf(reply.c_str(), "%d %d", &attempts, &successes);
    ++state.done;
    state.attempts += attempts;
    state.successes += successes;
    if (listener.on_trial) listener.on_trial(state);
  };
  plan.on_message = listener.on_message;
  plan.stop = listener.stop;
  WorkReport work = RunInWorkers(plan);

  RunReport report;
  report.trials = ResultsStore(options.out, identity).ReadAll();
  report.summary = Summarize(report.trials, spec.cycle);
  report.summary.forecasts = ForecastsOf(report.trials, objects, options.tolerance);
  report.interrupted = work.stopped;
  report.lost = std::move(work.lost);
  WriteReports(report.trials, objects, report.summary, options);
  return report;
}

}  // namespace pickbed
