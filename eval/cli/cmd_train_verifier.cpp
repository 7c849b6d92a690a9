#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/train_messages.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/train/job.h"
#include "perception/networks/model_file.h"
#include "perception/training/shared_verifier.h"
#include "perception/training/training.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

struct TrainVerifierArguments {
  TrainingSetChoice training_set;
  std::string model = "shipped";
  std::string file = "models/rooms.net";
  bool resume = false;
  TrainingOptions training;
};

int Train(const TrainVerifierArguments& arguments) {
  TrainingSetChoice choice = arguments.training_set;
  choice.start_from = TrainedFile(arguments.model).string();
  for (const ModelObject& object : LoadModel(choice.start_from).info.objects) {
    choice.objects.push_back(object.name);
  }
  const TrainingSet training_set = PlanTrainingSet(choice);
  const std::filesystem::path file = arguments.file;
  const std::filesystem::path unfinished = UnfinishedSharedVerifier(file);
  CheckInput(
      !arguments.resume || std::filesystem::exists(unfinished),
      fmt::format("no {} to resume from; remove --resume to start anew", unfinished.string()));
  if (file.has_parent_path()) MakeFolder(file.parent_path());
  RequireWritable(file);
  const auto views = MakeTrainingViews(training_set);
  CatchInterrupts();
  SharedVerifierReport report;
  {
    ProgressLine progress;
    const ObjectSet& objects = training_set.objects;
    std::optional<double> resumed_from;
    const auto show = [&](std::string_view name, double share) {
      const auto current = std::ranges::find(objects, name, [](const auto& o) { return o->name; });
      const auto index = static_cast<double>(current - objects.begin());
      const double done = (index + share) / static_cast<double>(objects.size());
      resumed_from = resumed_from.value_or(done);
      const std::string content = fmt::format("object {:.0f}/{}, {}: {}", index + 1, objects.size(),
                                              name, WholePercentText(share));
      const double left_s =
          done > *resumed_from ? progress.elapsed_s() * (1 - done) / (done - *resumed_from) : -1;
      progress.ShowTimed(fmt::format("{}  left {}", content, FormatDuration(left_s)), content);
      return !Interrupted();
    };
    const SharedVerifierJob job{*views,           choice.start_from,         file,
                                arguments.resume, SensorNames(training_set), show};
    report = TrainSharedVerifier(job, VerifierOptionsOf(arguments.training));
  }
  if (!report.finished) {
    SayStopped(unfinished,
               "the candidates of " + Counted(static_cast<size_t>(report.objects), "object"));
    return kExitInterrupted;
  }
  fmt::print(
      "wrote {}, trained on {} candidates of {} objects, of which {} are right\nuse it with "
      "`pickbed train OBJECT --set shared_verifier={}`\n",
      file.string(), report.candidates, report.objects, report.right, file.string());
  return 0;
}

}  // namespace

int TrainVerifierCommand(int argc, char** argv) {
  CLI::App app(
      "Trains a verifier network for unknown backgrounds on many objects: on the candidates of a "
      "descriptor model in simulated rooms. With shared_verifier, it gives half of the logit of "
      "an object that is trained later. It takes some minutes per object. "
      "Ctrl-C keeps the finished objects; --resume continues.",
      "pickbed train verifier");
  TrainVerifierArguments arguments;
  // There are ten times as many candidates as for one object. They need more steps and cannot be
  // learned by heart.
  arguments.training.verifier.iterations = 20000;
  arguments.training.verifier.networks = 1;  // as in the benchmark of rooms
  arguments.training.verifier.weight_decay = 1e-5;
  std::vector<std::string> settings;
  app.add_option("--from", arguments.model, "descriptor model; rooms of all its objects are used")
      ->capture_default_str();
  app.add_option("--sensor", arguments.training_set.sensors,
                 "sensor profiles in addition to kinect_v1, structured_light and active_stereo, "
                 "separated by commas")
      ->delimiter(',');
  app.add_option("--catalog", arguments.training_set.scenario.catalog,
                 "folder with your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.file, "file to write")->capture_default_str();
  app.add_flag("--resume", arguments.resume, "continue an interrupted training");
  app.add_option("--seed", arguments.training.seed,
                 "random seed; the same seed gives the same file")
      ->capture_default_str();
  app.add_option("--set", settings,
                 "change a training setting: KEY=VALUE; verifier_room_scenes, "
                 "verifier_entries, verifier.*, candidates.* and fast_candidates.* have an effect")
      ->allow_extra_args(false);
  app.footer("Example: pickbed train verifier --set verifier_room_scenes=20");
  if (!ParseArguments(app, argc, argv)) return 0;
  for (const std::string& setting : settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { arguments.training.Visit(v); });
  }
  return Train(arguments);
}

}  // namespace pickbed::eval
