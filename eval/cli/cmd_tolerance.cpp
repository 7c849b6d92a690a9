#include <fmt/format.h>

#include <set>
#include <sstream>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/stats/statistics.h"
#include "eval/sweep/recorded_picks.h"
#include "eval/tolerance/report.h"
#include "grasp/grippers/requirements.h"
#include "grasp/grippers/table.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/resting_poses.h"

namespace pickbed::eval {
namespace {

struct ToleranceArguments {
  std::string object, gripper, catalog = "objects", out, run;
  std::vector<std::string> settings;
  std::vector<std::string> pairs;
  int jobs = 1;
  bool resume = false, quick = false;
};

bool ParseToleranceArguments(int argc, char** argv, ToleranceArguments& arguments) {
  CLI::App app(
      "Measures how large a pose error may be before the pick fails. Shifts and rotates the "
      "estimated pose of a single object on a table along each axis of the object and of the "
      "gripper, executes many grasps in simulation, and draws the success rates. Fits a model of "
      "P(pick succeeds | pose error) and compares it with MSSD, ADD and ADI as predictors of "
      "success.",
      "pickbed tolerance");
  app.add_option("OBJECT", arguments.object, "name of an object (see pickbed list objects)")
      ->required();
  app.add_option("GRIPPER", arguments.gripper,
                 "name of a gripper (see pickbed list grippers), or a .yaml file")
      ->required();
  app.add_option(
         "--pairs", arguments.pairs,
         "pairs of axes to vary together, for example x:rz or gx:gry, or all for every pair of one "
         "frame; axes x y z rx ry rz of the object, gx gy gz grx gry grz of the gripper")
      ->delimiter(',');
  app.add_option(
         "--run", arguments.run,
         "results folder of a `pickbed run`: also test the predictors on its picks of this object")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--quick", arguments.quick,
               "coarse map over the same range, in one or two minutes; --set changes its settings");
  app.add_option("--set", arguments.settings,
                 fmt::format("change a setting of the map: KEY=VALUE, for example grasps=80 or "
                             "step_mm=1; {} in the results folder lists all",
                             kToleranceFile));
  app.add_option("--catalog", arguments.catalog, "folder with your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "results folder [results/tolerance_OBJECT_GRIPPER]");
  AddJobsArgument(app, arguments.jobs);
  app.add_flag("--resume", arguments.resume, "continue an interrupted map");
  app.footer("Example: pickbed tolerance flange jaw_8cm --pairs gx:gry --jobs 2");
  return ParseArguments(app, argc, argv);
}

std::vector<std::array<int, 2>> AxisPairs(const std::vector<std::string>& texts) {
  std::vector<std::array<int, 2>> pairs;
  const auto axes = ErrorAxisTable();
  for (const std::string& text : texts) {
    if (text == "all") {
      for (int a = 0; a < static_cast<int>(axes.size()); ++a) {
        for (int b = a + 1; b < static_cast<int>(axes.size()); ++b) {
          if (axes[a].of_grasp == axes[b].of_grasp) pairs.push_back({a, b});
        }
      }
      continue;
    }
    const size_t colon = text.find(':');
    CheckInput(
        colon != std::string::npos,
        fmt::format("--pairs {}: write two axes separated by a colon, for example x:rz, or all",
                    text));
    const int a = ErrorAxisNamed(text.substr(0, colon));
    const int b = ErrorAxisNamed(text.substr(colon + 1));
    CheckInput(a != b && axes[a].of_grasp == axes[b].of_grasp,
               fmt::format("--pairs {}: takes two different axes of one frame: both of the object "
                           "(x y z rx ry rz) or both of the gripper (gx gy gz grx gry grz)",
                           text));
    pairs.push_back({a, b});
  }
  return pairs;
}

ToleranceOptions OptionsOf(const ToleranceArguments& arguments) {
  ToleranceOptions options = arguments.quick ? QuickOptions() : ToleranceOptions();
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { options.Visit(v); });
  }
  options.pairs = AxisPairs(arguments.pairs);
  CheckInput(options.pairs.empty() || options.pair_stride <= options.steps,
             fmt::format("pair_stride = {}: must not be larger than steps = {}",
                         options.pair_stride, options.steps));
  return options;
}

ToleranceStudy MakeStudy(const ToleranceArguments& arguments) {
  const ToleranceOptions options = OptionsOf(arguments);
  const auto gripper = LoadGripper(arguments.gripper);
  const auto loaded = OpenCatalog(arguments.catalog).Load(arguments.object);
  RequireCanCarry(*gripper, *loaded);
  const auto object = WithRestingDirections({WithConvexPieces(loaded)})[0];
  fmt::print(stderr, "planning grasps and resting poses of {}\n", object->name);
  return PlanStudy(object, gripper, RequireCandidates(*object, *gripper), options);
}

StudyOutcomes ExecuteWithProgress(const ToleranceStudy& study, const std::filesystem::path& out,
                                  const ToleranceArguments& arguments) {
  ProgressLine progress;
  StudyListener listener;
  listener.on_progress = [&](int done, int total, int before) {
    ProgressState state;
    state.what = "grasp";
    state.done = done;
    state.total = total;
    state.done_before = before;
    progress.Show(state);
  };
  listener.stop = Interrupted;
  return ExecuteStudy(study, out, arguments.jobs, arguments.resume, listener);
}

// Returns a warning line if the picks are from few bins.
std::string FewBinsLine(const std::vector<JudgedPick>& picks) {
  std::set<int> bins;
  for (const JudgedPick& pick : picks) bins.insert(pick.cluster);
  const std::string few = FewBinsText(static_cast<int>(bins.size()));
  return few.empty() ? few : "  " + few + "\n";
}

}  // namespace

int ToleranceCommand(int argc, char** argv) {
  ToleranceArguments arguments;
  if (!ParseToleranceArguments(argc, argv, arguments)) return 0;
  CatchInterrupts();
  const ToleranceStudy study = MakeStudy(arguments);
  const ObjectModel& object = *study.table.objects[0];
  const std::filesystem::path out = OutFolder(
      arguments.out, fmt::format("tolerance_{}_{}", object.name, study.table.gripper->name));
  std::vector<JudgedPick> picks;
  if (!arguments.run.empty()) {
    picks = PicksOfRun(arguments.run, arguments.catalog, object.name, study.table.gripper->name);
  }
  MakeFolder(out);
  const StudyOutcomes executed = ExecuteWithProgress(study, out, arguments);
  if (executed.interrupted) {
    fmt::print(stderr, "pickbed: stopped; repeat the same command with --resume to continue\n");
    return kExitInterrupted;
  }
  if (!executed.lost.empty()) {
    throw std::runtime_error(
        fmt::format("{} groups of grasps failed, the first: {}; --resume repeats them",
                    executed.lost.size(), executed.lost.front().why));
  }
  const ToleranceStatistics statistics = StatisticsOf(study, executed.outcomes);
  WriteToleranceFiles(study, statistics, out);
  fmt::print("{}", ToleranceText(statistics));
  if (!arguments.run.empty()) {
    const auto predictors = JudgePredictors({{statistics.model, object, picks}});
    WriteFileAtomically(out / kRunPredictorsFile, PredictorsCsv(predictors));
    fmt::print("{}{}", PredictorText(predictors, "picks of " + arguments.run), FewBinsLine(picks));
  }
  fmt::print("results in {}\n", out.string());
  return 0;
}

}  // namespace pickbed::eval
