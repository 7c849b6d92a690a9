// Pages of the settings: all keys of the files that users write, and of --set of each command.

#include <fmt/format.h>

#include "eval/benchmark/crops.h"
#include "eval/grasps/gripper_frame.h"
#include "eval/grasps/physics_trials.h"
#include "eval/reference/markdown.h"
#include "eval/reference/pages.h"
#include "eval/success/success_training.h"
#include "eval/sweep/sweep_spec.h"
#include "eval/tolerance/report.h"
#include "eval/tolerance/samples.h"
#include "grasp/candidates/candidates.h"
#include "grasp/grippers/table.h"
#include "perception/completion/completion_training.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/estimators/score_calibration.h"
#include "perception/training/training.h"
#include "perception/training/verifier_training.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/objects/object_settings.h"
#include "scenes/scenario/scenario_spec.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {
namespace {

template <typename Settings>
std::vector<SettingRow> RowsOf(Settings settings) {
  return SettingRows([&](SettingsVisitor& v) { settings.Visit(v); });
}

SettingsSource SweepFile() {
  SettingsSource source{
      "Sweep file",
      "A sweep file names a scenario and the settings that vary. The keys in `set` and `grid` are "
      "full keys of a scenario file, such as `estimator.name`. A value of `grid` is a list, a "
      "range such as `1..3`, or a map of labels with several settings each.",
      {}};
  for (const SweepKey& key : SweepKeys()) {
    source.rows.push_back({key.name, key.value, "", "", key.help});
    if (std::string(key.name) != "slurm") continue;
    for (SettingRow& row : RowsOf(SlurmOptions())) {
      row.key = "slurm." + row.key;
      source.rows.push_back(std::move(row));
    }
  }
  return source;
}

std::vector<SettingsSource> GripperFiles() {
  std::vector<SettingsSource> sources;
  for (const GripperRow& mechanism : GripperTable()) {
    const std::shared_ptr<Gripper> gripper = mechanism.make();
    sources.push_back({fmt::format("Gripper file, mechanism `{}`", mechanism.name),
                       fmt::format("{}. `gripper: NAME` in a scenario reads "
                                   "`assets/grippers/NAME.yaml`, or a file.",
                                   mechanism.help),
                       SettingRows([&](SettingsVisitor& v) {
                         std::string name = mechanism.name;
                         v.Text("mechanism", name, MechanismNames(), "mechanism of the hand");
                         gripper->Visit(v);
                       })});
  }
  return sources;
}

// Settings of the networks that are trained before their verifiers.
std::vector<SettingsSource> NetworkSettings() {
  std::vector<SettingsSource> sources;
  for (const EstimatorRow& row : EstimatorTable()) {
    const auto training = row.make_training ? row.make_training() : nullptr;
    if (!training || training->kind() != TrainingKind::kNetworkAndVerifiers) continue;
    sources.push_back(
        {fmt::format("Network of `{}`", row.name),
         fmt::format("Settings of `pickbed train {}`, in addition to the settings of verifiers.",
                     row.name),
         SettingRows([&](SettingsVisitor& v) {
           v.Group(
               std::string(row.name).c_str(),
               [&](SettingsVisitor& g) { training->VisitNetworkOptions(g); }, "its network");
         })});
  }
  return sources;
}

SettingsPage ScenarioSettings() {
  return {"settings.md",
          "Settings of a scenario",
          {{"Scenario file",
            "A scenario file is YAML. Every key has a default, except `objects`. `--set KEY=VALUE` "
            "changes a key of any command that reads a scenario; the index of a list item is a "
            "number, as in `--set objects.0.count=5`. `pickbed list settings` prints the same "
            "keys. Other settings: [files of objects, bins, sensors, grippers and "
            "sweeps](settings_files.md), [training](settings_training.md), [shape "
            "completion](settings_completion.md), [benchmark and tolerance "
            "maps](settings_measurements.md), [grasps](settings_grasps.md).",
            RowsOf(ScenarioSpec())}}};
}

SettingsPage FileSettings() {
  SettingsPage page{
      "settings_files.md",
      "Settings of objects, bins, sensors, grippers and sweeps",
      {{"Object file",
        fmt::format("`{}` is in the folder of an object, next to its mesh. `pickbed object add` "
                    "writes it. Give one of `mass_kg` and `density_kgpm3`.",
                    kObjectFile),
        SettingRows(VisitObjectSettings)},
       {"Bin file",
        "`bin.name: NAME` in a scenario reads `assets/bins/NAME.yaml`, or a file. The same keys "
        "are in the group `bin` of a scenario.",
        RowsOf(BinSpec())},
       {"Sensor file",
        "`sensor: NAME` in a scenario reads `assets/sensors/NAME.yaml`, or a file. The default of "
        "a key disables its effect. `min_range_m`, `max_range_m` and `quantization_m` must be "
        "given.",
        RowsOf(SensorProfile())},
       {"Calibration file",
        "`pickbed calibrate` writes it. `estimator.calibration` in a scenario names it.",
        RowsOf(ScoreCalibration())},
       {"Frame of a hand", "`pickbed grasps --frame FILE.yaml` reads it.",
        RowsOf(GripperFrame())}}};
  for (SettingsSource& source : GripperFiles()) page.sources.push_back(std::move(source));
  page.sources.push_back(SweepFile());
  return page;
}

SettingsPage TrainingSettings() {
  SettingsPage page{
      "settings_training.md",
      "Settings of training",
      {{"Patch networks",
        "Settings of `pickbed train --set`, with the defaults of `descriptor`. `pickbed "
        "train kehl` and `doumanoglou` have the same keys and other defaults.",
        RowsOf(EstimatorNamed("descriptor").make_training()->PatchNetworkOptions())},
       {"Verifiers", "Settings of `pickbed train --verifier-for`.",
        RowsOf(VerifierTrainingOptions())}}};
  for (SettingsSource& source : NetworkSettings()) page.sources.push_back(std::move(source));
  return page;
}

SettingsPage CompletionSettings() {
  return {"settings_completion.md",
          "Settings of shape completion",
          {{"Training of shape completion", "Settings of `pickbed train completion --set`.",
            RowsOf(CompletionTrainingOptions())},
           {"Training of the network for grasps", "Settings of `pickbed train grasps --set`.",
            RowsOf(SuccessTrainingOptions())}}};
}

SettingsPage MeasurementSettings() {
  return {"settings_measurements.md",
          "Settings of benchmark and tolerance maps",
          {{"Crop benchmark", "Settings of `pickbed benchmark crops --set`.",
            RowsOf(CropBenchmarkOptions())},
           {"Tolerance map",
            fmt::format("Settings of `pickbed tolerance --set`; `{}` in its results folder has the "
                        "effective values.",
                        kToleranceFile),
            RowsOf(ToleranceOptions())}}};
}

SettingsPage GraspSettings() {
  return {"settings_grasps.md",
          "Settings of grasps",
          {{"Grasps", "Settings of `pickbed grasps --set`.", RowsOf(GraspCandidateOptions())},
           {"Tested grasps", "Settings of `pickbed grasps --from FILE --set`.",
            RowsOf(GraspTestOptions())}}};
}

std::vector<std::string> CellsOf(const SettingRow& row) {
  const bool is_word = row.default_value == kEmptySetting;
  return {MarkdownCode(row.key), MarkdownText(row.value),
          is_word ? row.default_value : MarkdownCode(row.default_value), MarkdownText(row.unit),
          MarkdownText(row.help)};
}

// First the keys without a group, then a table for each outermost group.
std::string TablesOf(const SettingsSource& source) {
  const std::vector<std::string> header{"key", "value", "default", "unit", "meaning"};
  std::vector<std::vector<std::string>> single{header}, group{header};
  std::string groups;
  const auto end_group = [&] {
    if (group.size() > 1) groups += "\n" + MarkdownTable(group);
    group = {header};
  };
  bool in_group = false;
  for (const SettingRow& row : source.rows) {
    const bool is_outermost = row.key.find('.') == std::string::npos;
    if (is_outermost) in_group = row.value == "group" || row.value == "list";
    if (is_outermost && in_group) {
      end_group();
      groups +=
          fmt::format("\n### {}\n\n{}{}: {}.\n", row.key, row.value == "list" ? "List" : "Group",
                      row.default_value.empty() ? "" : ", default " + row.default_value,
                      MarkdownText(row.help));
      continue;
    }
    (in_group ? group : single).push_back(CellsOf(row));
  }
  end_group();
  return (single.size() > 1 ? "\n" + MarkdownTable(single) : "") + groups;
}

}  // namespace

std::vector<SettingsPage> AllSettings() {
  return {ScenarioSettings(),   FileSettings(),        TrainingSettings(),
          CompletionSettings(), MeasurementSettings(), GraspSettings()};
}

void AddSettingsPages(Pages& pages) {
  for (const SettingsPage& page : AllSettings()) {
    std::string& text = pages[page.file] = PageHead(page.title);
    for (const SettingsSource& source : page.sources) {
      text += fmt::format("{}## {}\n\n{}\n{}", &source == &page.sources.front() ? "" : "\n",
                          source.title, source.intro, TablesOf(source));
    }
  }
}

}  // namespace pickbed::eval
