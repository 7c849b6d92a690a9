#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/grasp_sheet.h"
#include "eval/export/grasps_csv.h"
#include "eval/grasps/report.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/stats/statistics.h"
#include "grasp/grippers/requirements.h"
#include "grasp/grippers/table.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/resting_poses.h"

namespace pickbed::eval {
namespace {

struct GraspsArguments {
  std::string object, gripper, out, from, write, frame = "tips";
  std::string catalog = "objects";
  int count = 0;  // 0 = all
  int jobs = 1;
  bool ignore_names = false;
  std::vector<std::string> settings;
};

void Apply(const std::vector<std::string>& settings, const VisitFunction& visit) {
  for (const std::string& setting : settings) ApplySetting(setting, visit);
}

void WriteFile(const GraspsArguments& arguments, const ObjectModel& model, const Gripper& gripper,
               const std::vector<GraspCandidate>& candidates) {
  if (arguments.write.empty()) return;
  WriteGraspFile(arguments.write, model, gripper, LoadGripperFrame(arguments.frame), candidates);
  fmt::print("{}\n", arguments.write);
}

// Checks before the work that the file of --write can be written. `folder`: results folder, which
// may be made later.
void RequireWritableFile(const GraspsArguments& arguments, const std::filesystem::path& folder) {
  if (arguments.write.empty()) return;
  RequireGraspFormat(arguments.write, LoadGripperFrame(arguments.frame));
  const auto written = std::filesystem::absolute(arguments.write).parent_path();
  if (written.lexically_normal() == std::filesystem::absolute(folder).lexically_normal()) return;
  RequireWritable(arguments.write);
}

std::filesystem::path GraspsFolder(const GraspsArguments& arguments, const ObjectModel& model,
                                   const Gripper& gripper) {
  return arguments.out.empty() ? std::filesystem::path("results") /
                                     fmt::format("grasps_{}_{}", model.name, gripper.name)
                               : std::filesystem::path(arguments.out);
}

void WriteGrasps(const GraspsArguments& arguments) {
  const ObjectSet objects{OpenCatalog(arguments.catalog).Load(arguments.object)};
  const auto gripper = LoadGripper(arguments.gripper);
  LoadGripperFrame(arguments.frame);
  RequireCanCarry(*gripper, *objects[0]);
  const std::filesystem::path folder = GraspsFolder(arguments, *objects[0], *gripper);
  RequireWritableFile(arguments, folder);
  const auto model = WithRestingDirections(WithConvexPieces(objects))[0];
  GraspCandidateOptions options;
  if (arguments.count > 0) {
    options.antipodal.candidates = options.suction.candidates = arguments.count;
    options.antipodal.resting_candidates = 0;
  }
  Apply(arguments.settings, [&](SettingsVisitor& v) { options.Visit(v); });
  auto candidates = RequireCandidates(*model, *gripper, options);
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a.robust, a.epsilon) > std::make_pair(b.robust, b.epsilon);
  });

  MakeFolder(folder);
  WriteFileAtomically(folder / kGraspsFile, GraspsCsv(candidates));
  WritePng(folder / kGraspSheetFile, GraspSheet(*model, *gripper, candidates));
  const GraspCandidate& best = candidates.front();
  fmt::print(
      "{} grasps of {} with {}; the best one succeeds for {} of the sampled errors and "
      "resists {:.1f} times the weight from any direction\n{}\n",
      candidates.size(), model->name, gripper->name, WholePercentText(best.robust), best.epsilon,
      (folder / kGraspsFile).string());
  fmt::print("picture: {}\n", (folder / kGraspSheetFile).string());
  WriteFile(arguments, *model, *gripper, candidates);
}

// Tests the grasps of a file. Returns the exit status.
int TestFile(const GraspsArguments& arguments) {
  const ObjectSet objects{OpenCatalog(arguments.catalog).Load(arguments.object)};
  GraspTestJob job;
  job.gripper = LoadGripper(arguments.gripper);
  const GripperFrame frame = LoadGripperFrame(arguments.frame);
  Apply(arguments.settings, [&](SettingsVisitor& v) { job.options.Visit(v); });
  const GraspFile file = ReadGraspFile(arguments.from);
  RequireGraspsOf(file, *objects[0], *job.gripper, frame, !arguments.ignore_names);
  RequireCanCarry(*job.gripper, *objects[0]);
  const std::filesystem::path folder = GraspsFolder(arguments, *objects[0], *job.gripper);
  RequireWritableFile(arguments, folder);
  MakeFolder(folder);
  RequireWritable(folder / kGraspTestsFile);
  job.object = WithRestingDirections(WithConvexPieces(objects))[0];
  job.candidates = CandidatesOf(file, *job.object, *job.gripper, frame);
  WriteFile(arguments, *job.object, *job.gripper, job.candidates);
  job.jobs = arguments.jobs;
  CatchInterrupts();
  ProgressLine progress;
  std::string work;
  job.on_progress = [&](const std::string& what, int done, int total) {
    if (what != work) progress.Restart();
    work = what;
    ProgressState state;
    state.what = what;
    state.done = done;
    state.total = total;
    progress.Show(state);
  };
  job.stop = Interrupted;
  const GraspTests tests = TestGrasps(job);
  if (tests.interrupted) {
    fmt::print(stderr, "pickbed: stopped\n");
    return kExitInterrupted;
  }
  WriteFileAtomically(folder / kGraspTestsFile, GraspTestsCsv(file, tests));
  fmt::print("{}{}\n", GraspTestsText(file, tests, job.options),
             (folder / kGraspTestsFile).string());
  return 0;
}

std::string FramesHelp() {
  std::string text = "\nFrames of --frame:\n";
  for (const GripperFrameRow& row : GripperFrameTable()) {
    text += fmt::format("  {:<12} {}\n", row.name, row.help);
  }
  return text;
}

}  // namespace

int GraspsCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format("Plans grasps of an object with a gripper. Writes them to {}, best first, and a "
                  "picture of the best ones to {}. With --from, tests the grasps of a file in "
                  "physics instead: on a table with a hold test, and in bins.",
                  kGraspsFile, kGraspSheetFile),
      "pickbed grasps");
  GraspsArguments a;
  app.add_option("OBJECT", a.object, "name of an object (see pickbed list objects)")->required();
  app.add_option("GRIPPER", a.gripper,
                 "name of a gripper (see pickbed list grippers), or a .yaml file")
      ->required();
  auto* count =
      app.add_option("--count", a.count,
                     "maximum number of grasps, for any orientation of the object (default: all "
                     "grasps that a run can choose from)")
          ->check(CLI::Range(1, 100000));
  auto* from =
      app.add_option("--from", a.from, "test the grasps of this file: isaac_grasp (.yaml) or .csv")
          ->excludes(count);
  app.add_option("--write", a.write,
                 "also write the grasps to this file: isaac_grasp (.yaml) or .csv");
  app.add_option("--frame", a.frame,
                 "frame of the hand in these files: a name, or a .yaml file with approach, closing "
                 "and tip_m")
      ->capture_default_str();
  app.add_flag("--ignore-names", a.ignore_names,
               "test the grasps although the file names another object or gripper")
      ->needs(from);
  AddJobsArgument(app, a.jobs);
  app.add_option(
      "--set", a.settings,
      "change a setting: KEY=VALUE, for example robust.position_m=0.003, or with --from bins=10; "
      "may be repeated");
  app.add_option("--catalog", a.catalog, "folder with your own objects")->capture_default_str();
  app.add_option("--out", a.out, "results folder [results/grasps_OBJECT_GRIPPER]");
  GraspCandidateOptions defaults;
  GraspTestOptions test_defaults;
  app.footer(fmt::format(
      "Settings and their defaults:\n{}\nSettings with --from:\n{}{}\nExample: pickbed grasps "
      "bracket jaw_8cm --count 200\n         pickbed grasps bracket jaw_8cm --from grasps.yaml",
      WriteSettings([&](SettingsVisitor& v) { defaults.Visit(v); }, true),
      WriteSettings([&](SettingsVisitor& v) { test_defaults.Visit(v); }, true), FramesHelp()));
  if (!ParseArguments(app, argc, argv)) return 0;
  if (!a.from.empty()) return TestFile(a);
  WriteGrasps(a);
  return 0;
}

}  // namespace pickbed::eval
