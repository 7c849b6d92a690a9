#include "eval/run.h"

#include <fmt/format.h>

#include "eval/oracle.h"
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

std::string SettingsText(ScenarioSpec spec) {
  return WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
}

// What tolerance maps make of a run, into its files.
void WriteForecasts(const ObjectSet& objects, const RunOptions& options, RunReport& report) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  report.summary.forecasts = ForecastsOf(report.trials, objects, options.tolerance);
  WriteFileAtomically(options.out / "summary.json", SummaryJson(report.summary));
  WriteFileAtomically(options.out / "picks.csv", PicksCsv(report.trials, names, options.tolerance));
  WriteFileAtomically(options.out / "pick_chances.csv",
                      PickChancesCsv(report.trials, objects, options.tolerance));
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
  same_for_all.stop_width = 0;
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
    for (size_t i = 0; i < objects.size(); ++i) {
      if (!spec.objects[i].foreign) RequireCanCarry(gripper, *objects[i]);
    }
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

Sweep SweepOfOne(const ScenarioSpec& spec, const ObjectSet& objects, const TruthStages& truth) {
  SweepPoint point;
  point.spec = spec;
  point.objects = objects;
  point.identity = RunIdentity(spec, objects, truth);
  point.trials = spec.trials;
  return {{point}, ""};
}

RunReport RunScenario(const ScenarioSpec& spec, const ObjectSet& objects, const RunOptions& options,
                      const RunListener& listener) {
  SweepOptions sweep_options;
  sweep_options.out = options.out;
  sweep_options.jobs = options.jobs;
  sweep_options.resume = options.resume;
  sweep_options.retry_crashed = options.retry_crashed;
  sweep_options.picture_trials = options.picture_trials;
  sweep_options.lost_picture_trials = options.lost_picture_trials;
  sweep_options.only_trials = options.only_trials;
  TrialOptions trial_options;
  trial_options.truth = options.truth;
  sweep_options.make = PickingTrials(trial_options);
  SweepReport swept = RunSweep(SweepOfOne(spec, objects, options.truth), sweep_options, listener);

  RunReport report;
  report.trials = ResultsStore::OpenToRead(options.out).ReadAll();
  report.summary = std::move(swept.points.front().summary);
  report.interrupted = swept.interrupted;
  report.crashed = std::move(swept.crashed);
  if (!options.tolerance.empty()) WriteForecasts(objects, options, report);
  return report;
}

}  // namespace pickbed
