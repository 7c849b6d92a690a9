#include <fmt/format.h>

#include <set>
#include <sstream>
#include <thread>

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
  int jobs = std::max(1u, std::thread::hardware_concurrency());
  bool resume = false;
};

bool ParseToleranceArguments(int argc, char** argv, ToleranceArguments& arguments) {
  CLI::App app(
      "How wrong may a pose be and the pick still succeed? Pushes the pose of a part alone on a "
      "table along and about each axis of the part and of the hand, executes many grasps in "
      "physics, and draws the share that succeeds. A model of P(pick succeeds | pose error) is "
      "fitted to the outcomes and held against MSSD, ADD and ADI as a forecast of picks.",
      "pickbed tolerance");
  app.add_option("OBJECT", arguments.object, "a name of `pickbed list objects`")->required();
  app.add_option("GRIPPER", arguments.gripper, "a name of `pickbed list grippers`, or a file")
      ->required();
  app.add_option("--pairs", arguments.pairs,
                 "pairs of axes to push along together, as x:rz or gx:gry, or all: those of one "
                 "frame; axes x y z rx ry rz of the part, gx gy gz grx gry grz of the hand")
      ->delimiter(',');
  app.add_option("--run", arguments.run,
                 "results folder of `pickbed run`: judge the scores by its picks of this part, too")
      ->check(CLI::ExistingDirectory);
  app.add_option(
      "--set", arguments.settings,
      "KEY=VALUE of the map's settings, as grasps=80 or step_mm=1; tolerance.yaml in the "
      "results folder shows all");
  app.add_option("--catalog", arguments.catalog, "folder of your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.out,
                 "results folder (default: results/tolerance_OBJECT_GRIPPER)");
  app.add_option("--jobs", arguments.jobs, "worker processes; results do not depend on it")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_flag("--resume", arguments.resume, "go on with a map that was stopped");
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
    CheckInput(colon != std::string::npos,
               fmt::format("--pairs {}: write two axes with a colon, as x:rz, or all", text));
    const int a = ErrorAxisNamed(text.substr(0, colon));
    const int b = ErrorAxisNamed(text.substr(colon + 1));
    CheckInput(a != b && axes[a].of_grasp == axes[b].of_grasp,
               fmt::format("--pairs {}: takes two different axes of one frame: both of the part "
                           "(x y z rx ry rz) or both of the hand (gx gy gz grx gry grz)",
                           text));
    pairs.push_back({a, b});
  }
  return pairs;
}

ToleranceOptions OptionsOf(const ToleranceArguments& arguments) {
  ToleranceOptions options;
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { options.Visit(v); });
  }
  options.pairs = AxisPairs(arguments.pairs);
  CheckInput(options.pairs.empty() || options.pair_stride <= options.steps,
             fmt::format("pair_stride = {}: must not be over steps = {}", options.pair_stride,
                         options.steps));
  return options;
}

ToleranceStudy MakeStudy(const ToleranceArguments& arguments) {
  const ToleranceOptions options = OptionsOf(arguments);
  const auto gripper = LoadGripper(arguments.gripper);
  const auto loaded = OpenCatalog(arguments.catalog).Load(arguments.object);
  RequireCanCarry(*gripper, *loaded);
  const auto part = WithRestingDirections({WithConvexPieces(loaded)})[0];
  fmt::print(stderr, "grasps and resting poses of {}\n", part->name);
  return PlanStudy(part, gripper, RequireCandidates(*part, *gripper), options);
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
  const ObjectModel& part = *study.table.objects[0];
  const std::filesystem::path out = OutFolder(
      arguments.out, fmt::format("tolerance_{}_{}", part.name, study.table.gripper->name));
  std::vector<JudgedPick> picks;
  if (!arguments.run.empty()) {
    picks = PicksOfRun(arguments.run, arguments.catalog, part.name, study.table.gripper->name);
  }
  MakeFolder(out);
  const StudyOutcomes executed = ExecuteWithProgress(study, out, arguments);
  if (executed.interrupted) {
    fmt::print(stderr, "pickbed: stopped; the same command with --resume goes on\n");
    return kExitInterrupted;
  }
  if (!executed.lost.empty()) {
    throw std::runtime_error(
        fmt::format("{} groups of grasps were lost, the first: {}; --resume tries them again",
                    executed.lost.size(), executed.lost.front().why));
  }
  const ToleranceFigures figures = FiguresOf(study, executed.outcomes);
  WriteToleranceFiles(study, figures, out);
  fmt::print("{}", ToleranceText(figures));
  if (!arguments.run.empty()) {
    const auto predictors = JudgePredictors({{figures.model, part, picks}});
    WriteFileAtomically(out / "run_predictors.csv", PredictorsCsv(predictors));
    fmt::print("{}{}", PredictorText(predictors, "picks of " + arguments.run), FewBinsLine(picks));
  }
  fmt::print("results in {}\n", out.string());
  return 0;
}

}  // namespace pickbed::eval
