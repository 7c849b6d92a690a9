#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/grasp_sheet.h"
#include "eval/export/grasps_csv.h"
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
  std::string object, gripper, out;
  std::string catalog = "objects";
  int count = 0;  // 0 = all
  std::vector<std::string> settings;
};

void WriteGrasps(const GraspsArguments& arguments) {
  const ObjectSet objects{OpenCatalog(arguments.catalog).Load(arguments.object)};
  const auto gripper = LoadGripper(arguments.gripper);
  RequireCanCarry(*gripper, *objects[0]);
  const auto model = WithRestingDirections(WithConvexPieces(objects))[0];
  GraspCandidateOptions options;
  if (arguments.count > 0) {
    options.antipodal.candidates = options.suction.candidates = arguments.count;
    options.antipodal.resting_candidates = 0;
  }
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { options.Visit(v); });
  }
  auto candidates = RequireCandidates(*model, *gripper, options);
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a.robust, a.epsilon) > std::make_pair(b.robust, b.epsilon);
  });

  const std::filesystem::path folder =
      arguments.out.empty() ? std::filesystem::path("results") /
                                  fmt::format("grasps_{}_{}", model->name, gripper->name)
                            : std::filesystem::path(arguments.out);
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
}

}  // namespace

int GraspsCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format("Plans grasps of an object with a gripper. Writes them to {}, best first, and a "
                  "picture of the best ones to {}.",
                  kGraspsFile, kGraspSheetFile),
      "pickbed grasps");
  GraspsArguments a;
  app.add_option("OBJECT", a.object, "name of an object (see pickbed list objects)")->required();
  app.add_option("GRIPPER", a.gripper,
                 "name of a gripper (see pickbed list grippers), or a .yaml file")
      ->required();
  app.add_option("--count", a.count,
                 "maximum number of grasps, for any orientation of the object (default: all grasps "
                 "that a run can choose from)")
      ->check(CLI::Range(1, 100000));
  app.add_option(
      "--set", a.settings,
      "change a setting: KEY=VALUE, for example robust.position_m=0.003; may be repeated");
  app.add_option("--catalog", a.catalog, "folder with your own objects")->capture_default_str();
  app.add_option("--out", a.out, "results folder [results/grasps_OBJECT_GRIPPER]");
  GraspCandidateOptions defaults;
  app.footer(fmt::format(
      "Settings and their defaults:\n{}\nExample: pickbed grasps bracket jaw_8cm --count 200",
      WriteSettings([&](SettingsVisitor& v) { defaults.Visit(v); }, true)));
  if (!ParseArguments(app, argc, argv)) return 0;
  WriteGrasps(a);
  return 0;
}

}  // namespace pickbed::eval
