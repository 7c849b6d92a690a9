#include <fmt/format.h>

#include "eval/benchmark/rooms.h"
#include "eval/benchmark/rooms_pictures.h"
#include "eval/benchmark/rooms_poses.h"
#include "eval/cli/arguments.h"
#include "eval/cli/benchmark/cmd_benchmark.h"
#include "eval/estimate/estimator_comparison.h"
#include "eval/frames/image_estimator.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "eval/train/job.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

struct RoomsArguments {
  TrainingSetChoice objects;
  std::string estimator = "descriptor:accurate";
  double min_score = kMinImageScore;
  std::string out;
  RoomsOptions rooms;
};

int RunRoomsTable(const RoomsArguments& arguments) {
  const TrainingSet set = PlanTrainingSet(arguments.objects);
  EstimatorSpec base;
  base.min_score = arguments.min_score;
  const EstimatorSpec spec = ParseEstimators({arguments.estimator}, base).front().spec;
  RequireMode(spec);
  const std::filesystem::path folder = OutFolder(arguments.out, "rooms");
  MakeFolder(folder);
  CatchInterrupts();
  const std::filesystem::path pictures = folder / "pictures";
  RemoveRoomPictures(pictures);  // of an earlier benchmark
  std::vector<RoomEstimate> estimates;
  size_t written = 0;
  std::string poses = HeaderLine(RoomPosesColumns());
  {
    const auto views = MakeTrainingViews(set);
    ProgressLine progress;
    ProgressState state;
    state.what = "image";
    RoomsCallbacks callbacks;
    callbacks.on_progress = [&](int done, int total) {
      state.done = done;
      state.total = total;
      progress.Show(state);
      return !Interrupted();
    };
    callbacks.on_estimate = [&](const LabelledView& view, const RoomEstimate& estimate) {
      poses += RoomPosesLines(views->objects(), view, estimate);
      written +=
          WriteRoomWithWrongPoses(pictures, views->objects(), view, estimate, arguments.min_score);
    };
    estimates = EstimateRooms(*views, spec, arguments.rooms, callbacks);
  }
  if (estimates.empty()) return kExitInterrupted;
  const std::vector<RoomsRow> rows = RoomsRowsOf(estimates, arguments.min_score);
  WriteFileAtomically(folder / kRoomsFile, RoomsCsv(rows));
  WriteFileAtomically(folder / kRoomPosesFile, poses);
  fmt::print("{}{} and {} in {}\n", RoomsText(rows), kRoomsFile, kRoomPosesFile, folder.string());
  if (written > 0) {
    fmt::print("{} of wrong poses in {}\n", Counted(written, "picture"), pictures.string());
  }
  return 0;
}

}  // namespace

int BenchmarkRoomsCommand(int argc, char** argv) {
  CLI::App app(
      "Estimates poses in simulated rooms whose background is not known: objects in bins, objects "
      "on tables among other things, and no object at all. The same images are also estimated with "
      "the given bin, and every second without looking for planes.",
      "pickbed benchmark rooms");
  RoomsArguments arguments;
  app.add_option("OBJECT", arguments.objects.objects, "objects of the catalog");
  app.add_option("--bop", arguments.objects.bop_path,
                 "use the models of this BOP dataset, with its camera");
  app.add_option("--sensor", arguments.objects.sensors,
                 "sensor profiles in addition to kinect_v1, structured_light and active_stereo, "
                 "separated by commas")
      ->delimiter(',');
  app.add_option("--estimator", arguments.estimator, "estimator as NAME:MODE or NAME:MODE=MODEL")
      ->capture_default_str();
  app.add_option("--min-score", arguments.min_score, "minimum score of a reported pose")
      ->capture_default_str();
  app.add_option("--bins", arguments.rooms.bins, "number of rooms with objects in a bin")
      ->capture_default_str();
  app.add_option("--tables", arguments.rooms.tables, "number of rooms with objects on a table")
      ->capture_default_str();
  app.add_option("--empty", arguments.rooms.empty, "number of rooms without an object")
      ->capture_default_str();
  app.add_option("--seed", arguments.rooms.seed, "random seed of the rooms")->capture_default_str();
  app.add_option("--catalog", arguments.objects.scenario.catalog, "folder with your own objects")
      ->capture_default_str();
  AddThreadsArgument(app, arguments.rooms.threads);
  app.add_option("--out", arguments.out, "results folder [results/rooms]");
  app.footer("Example: pickbed benchmark rooms bracket rod --estimator descriptor:fast");
  if (!ParseArguments(app, argc, argv)) return 0;
  return RunRoomsTable(arguments);
}

}  // namespace pickbed::eval
