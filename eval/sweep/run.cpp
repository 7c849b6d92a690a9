#include "eval/sweep/run.h"

#include <fmt/format.h>

#include "eval/runtime/results_folder.h"
#include "eval/shapes/completion_choice.h"
#include "eval/store/results_store.h"
#include "eval/summary/run_csv.h"
#include "eval/sweep/run_images.h"
#include "eval/trial/oracle_estimator.h"
#include "eval/trial/trial_setup.h"
#include "grasp/grippers/requirements.h"
#include "grasp/grippers/table.h"
#include "grasp/outcome.h"
#include "grasp/plan/plan.h"
#include "grasp/planners/table.h"
#include "grasp/tolerance/tolerance_ranking.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/estimators/process.h"
#include "perception/estimators/score_calibration.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/plugin/plugin_client.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {
namespace {

std::string SettingsText(ScenarioSpec spec) {
  return WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
}

// Adds the predictions of the tolerance models to the files of a run.
void WriteForecasts(const ObjectSet& objects, const RunOptions& options, RunReport& report) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  report.summary.forecasts = ForecastsOf(report.trials, objects, options.tolerance);
  WriteFileAtomically(options.out / kSummaryFile, SummaryJson(report.summary));
  WriteFileAtomically(options.out / kAttemptsFile,
                      AttemptsCsv(report.trials, names, options.tolerance));
  WriteFileAtomically(options.out / kPickChancesFile,
                      PickChancesCsv(report.trials, objects, options.tolerance));
}

// Hash of all properties of an object that affect a trial.
uint64_t ObjectHash(const ObjectModel& object) {
  std::vector<double> numbers{object.mass.mass_kg, object.friction};
  const auto add = [&](const auto& values) {
    numbers.insert(numbers.end(), values.data(), values.data() + values.size());
  };
  add(object.mass.com_O);
  add(object.mass.inertia_com_O);
  for (const Pose& X_OO : object.symmetries_O.discrete_O) add(X_OO.matrix());
  for (const ContinuousSymmetry& axis : object.symmetries_O.continuous_O) {
    add(axis.axis_O);
    add(axis.offset_O);
  }
  for (const ConvexPiece& piece : object.convex_pieces_O) {
    for (const Eigen::Vector3d& p_O : piece.vertices_O) add(p_O);
  }
  return HashBytes(numbers.data(), numbers.size() * sizeof(double), object.mesh_hash);
}

// What identifies the program of an estimator or planner: the contents of the files that its
// command names, such as a script. For a server, what it reports about itself. `settings` is the
// group `role` of the scenario.
template <typename Settings>
std::string ProgramText(const ScenarioSpec& spec, const std::string& role,
                        const Settings& settings) {
  if (!settings.connect.empty()) {
    const PluginAddress address{settings.command, settings.connect, settings.timeout_s};
    const PluginIdentity identity = WithSettingsKey(
        spec, role + ".connect", [&] { return PluginClient::IdentityOf(address, role); });
    return fmt::format("# {} '{}' version '{}'\n", role, identity.name, identity.version);
  }
  std::string text;
  for (const std::string& word : settings.command) {
    if (!std::filesystem::is_regular_file(word)) continue;
    const std::string bytes = ReadFileBytes(word);
    text += fmt::format("# program {:016x}\n", HashBytes(bytes.data(), bytes.size()));
  }
  return text;
}

// Returns the hash of a model file; empty if it does not exist, which the trial reports with a
// remedy.
std::string ModelText(const char* what, const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return "";
  const std::string bytes = ReadFileBytes(file);
  return fmt::format("# {} {:016x}\n", what, HashBytes(bytes.data(), bytes.size()));
}

// Returns the hashes of the models that a planner on completed shapes reads.
std::string ShapeModelsText(const PlannerSpec& spec, const PlannerRow& planner) {
  if (!planner.needs_shapes) return "";
  std::string text;
  const auto completion =
      ModelFileOf(planner.completion != nullptr ? planner.completion : spec.completion);
  if (completion) text += ModelText("completion", *completion);
  if (spec.success_model != kNoSuccessModel) {
    text += ModelText("success model", TrainedFile(spec.success_model));
  }
  return text;
}

constexpr char kOwnGraspsText[] = "# grasps chosen by a caller\n";

// Returns the trials in the results folder that captured an image.
std::vector<int> TrialsWithImages(const std::filesystem::path& folder) {
  std::vector<int> trials;
  if (!StoredSettings(folder)) return trials;
  ResultsStore::OpenToRead(folder).ForEach([&](const TrialResult& trial) {
    if (!trial.attempts.empty()) trials.push_back(trial.trial);
  });
  return trials;
}

std::string GroundTruthText(const OracleStages& truth) {
  return fmt::format("# truth for: sense {}, detection {}, pose {}, refinement {}, grasp {}\n",
                     truth.sense, truth.detection, truth.pose, truth.refinement, truth.grasp);
}

}  // namespace

std::string EstimatorFilesText(const ScenarioSpec& spec) {
  std::string text;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (spec.estimator.name != row.name || row.make_training == nullptr) continue;
    const std::filesystem::path file = row.make_training()->ModelFile(spec.estimator);
    if (!std::filesystem::exists(file)) continue;  // the estimator reports this with a remedy
    const std::string bytes = ReadFileBytes(file);
    text += fmt::format("# model {:016x}\n", HashBytes(bytes.data(), bytes.size()));
  }
  if (!spec.estimator.calibration.empty()) {
    WithSettingsKey(spec, "estimator.calibration", [&] {
      CheckInput(spec.estimator.name != kOracleName,
                 fmt::format("the score of {} is the visible fraction, which is not calibrated; "
                             "remove the calibration",
                             kOracleName));
      CalibrationFor(spec.estimator);
    });
    const std::string bytes = ReadFileBytes(spec.estimator.calibration);
    text += fmt::format("# calibration {:016x}\n", HashBytes(bytes.data(), bytes.size()));
  }
  if (spec.estimator.name == kProcessName) {
    text += ProgramText(spec, "estimator", spec.estimator);
  }
  if (ModelFileOf(spec.estimator.completion)) {
    text += ModelText("completion of the estimator", TrainedFile(spec.estimator.completion_model));
  }
  return text;
}

std::string RunIdentity(const ScenarioSpec& spec, const ObjectSet& objects,
                        const OracleStages& truth) {
  ScenarioSpec same_for_all = spec;
  same_for_all.trials = 1;
  same_for_all.stop_width = 0;
  same_for_all.cycle = {};
  // Mesh files are identified by content (below), not by path.
  same_for_all.bin.mesh.clear();
  for (ObjectSpec& object : same_for_all.objects) object.mesh.clear();
  std::string text = SettingsText(same_for_all);
  WithSettingsKey(spec, "estimator.name", [&] { RequireEstimator(spec.estimator.name); });
  const PlannerRow& planner = PlannerOf(spec, truth);
  if (planner.needs_poses && spec.estimator.name != kOracleName) {
    WithSettingsKey(spec, "estimator", [&] { RequireMode(spec.estimator); });
  }
  WithSettingsKey(spec, "refiner", [&] { RefinerNamed(spec.refiner); });
  WithSettingsKey(spec, "policy.ranking", [&] { RankingNamed(spec.policy.ranking); });
  WithSettingsKey(spec, "policy.success", [&] { DecidingRule(spec.policy.success); });
  // Contents of files that the settings refer to by name.
  const Tools tools =
      WithSettingsKey(spec, "gripper", [&] { return LoadTools(spec.gripper.names); });
  WithSettingsKey(spec, "gripper", [&] {
    for (const auto& tool : tools) RequireFitsBin(*tool, BinOf(spec));
    for (size_t i = 0; i < objects.size(); ++i) {
      if (!spec.objects[i].distractor) RequireSomeToolCarries(tools, *objects[i]);
    }
  });
  RequireSizesFit(spec, objects, tools);
  SensorProfile sensor =
      WithSettingsKey(spec, "sensor", [&] { return LoadSensorProfile(spec.sensor); });
  for (const auto& tool : tools) text += tool->SettingsText();
  text += WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); });
  for (const auto& object : objects) {
    text += fmt::format("# part {} is {:016x}\n", object->name, ObjectHash(*object));
  }
  if (!spec.bin.mesh.empty()) {
    const std::string bytes = ReadFileBytes(spec.folder / spec.bin.mesh);
    text += fmt::format("# bin {:016x}\n", HashBytes(bytes.data(), bytes.size()));
  }
  text += EstimatorFilesText(spec);
  if (spec.planner.name.starts_with("process")) {
    text += ProgramText(spec, "planner", spec.planner);
  }
  text += ShapeModelsText(spec.planner, planner);
  text += ToleranceRankingText(spec);
  if (truth != OracleStages()) text += GroundTruthText(truth);
  return text;
}

OracleStages TruthIn(const std::string& identity) {
  for (const OracleRow& row : OracleTable()) {
    if (identity.ends_with(GroundTruthText(row.truth))) return row.truth;
  }
  return {};
}

Sweep SweepOfOne(const ScenarioSpec& spec, const ObjectSet& objects, const OracleStages& truth) {
  Configuration configuration;
  configuration.spec = spec;
  configuration.objects = objects;
  configuration.identity = RunIdentity(spec, objects, truth);
  configuration.trials = spec.trials;
  return {{configuration}, ""};
}

RunReport RunScenario(const ScenarioSpec& spec, const ObjectSet& objects, const RunOptions& options,
                      const RunListener& listener) {
  SweepOptions sweep_options;
  sweep_options.out = options.out;
  sweep_options.jobs = options.jobs;
  sweep_options.resume = options.resume;
  sweep_options.retry_crashed = options.retry_crashed;
  sweep_options.picture_trials = options.picture_trials;
  sweep_options.failure_picture_trials = options.failure_picture_trials;
  sweep_options.only_trials = options.only_trials;
  TrialOptions trial_options;
  trial_options.truth = options.truth;
  trial_options.log_dir = options.out / kLogsFolder;
  sweep_options.make = PickingTrials(trial_options, options.bop_out);
  const Sweep sweep = SweepOfOne(spec, objects, options.truth);
  const std::string& identity = sweep.configurations.front().identity;
  if (!options.bop_out.empty()) {
    CheckInput(std::filesystem::absolute(options.bop_out) != std::filesystem::absolute(options.out),
               fmt::format("{}: is the folder of the results; choose another image folder",
                           options.bop_out.string()));
    BeginRunDataset(spec, objects, options.bop_out, options.out, identity, options.resume,
                    TrialsWithImages(options.out));
  }
  SweepReport swept = RunSweep(sweep, sweep_options, listener);
  if (!options.bop_out.empty() && !swept.interrupted) {
    FinishRunDataset(spec, objects, options.bop_out, identity, TrialsWithImages(options.out));
  }

  RunReport report;
  report.trials = ResultsStore::OpenToRead(options.out).ReadAll();
  report.summary = std::move(swept.configurations.front().summary);
  report.interrupted = swept.interrupted;
  report.crashed = std::move(swept.crashed);
  if (!options.tolerance.empty()) WriteForecasts(objects, options, report);
  return report;
}

void WriteRun(const ScenarioSpec& spec, const ObjectSet& objects,
              std::span<const TrialResult> trials, bool own_grasps,
              const std::filesystem::path& out) {
  CheckInput(!trials.empty(), "there is no finished trial to write");
  ScenarioSpec as_run = spec;
  as_run.trials = static_cast<int>(trials.size());
  Sweep sweep = SweepOfOne(as_run, objects);
  if (own_grasps) sweep.configurations.front().identity += kOwnGraspsText;
  const FolderLock lock(out);
  const StoreHead head = HeadOf(sweep, out);
  {
    ResultsStore store(out, head);
    CheckInput(
        store.FinishedTrials().empty(),
        fmt::format("{} already has finished trials; choose another results folder", out.string()));
    for (const TrialResult& trial : trials) store.Write(trial);
  }
  ResultsStore::Tidy(out);
  WriteFileAtomically(out / kScenarioFile, head.configurations.front().settings);
  WriteSweepFiles(out);
}

}  // namespace pickbed::eval
