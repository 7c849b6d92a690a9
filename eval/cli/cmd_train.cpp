#include <fmt/format.h>

#include <chrono>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/completion/commands.h"
#include "eval/cli/train_messages.h"
#include "eval/page/html.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/train/job.h"
#include "eval/train/page.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/training/training.h"
#include "perception/training/verifier_library.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

// Any laptop has two cores. The result does not depend on the number of threads.
constexpr int kThreads = 2;

struct TrainArguments {
  TrainingSetChoice training_set;   // its first object may be the name of the method
  std::vector<std::string> listed;  // from --objects
  std::string method = "descriptor";
  std::string model_file;
  std::string report_folder;
  bool resume = false;
  uint64_t seed = 0;
  double max_minutes = 0;
  TrainingOptions training;
  std::string verifier_for;  // estimator of which only the verifiers are trained
  VerifierTrainingOptions verifier;
  std::unique_ptr<EstimatorTraining> verifier_training;  // of this estimator
};

std::string CountText(const TrainingProgress& state) {
  return fmt::format("{} {}/{}", state.phase, state.done, state.total);
}

std::string ProgressText(const TrainingProgress& state) {
  std::string text = CountText(state);
  if (state.loss > 0) text += fmt::format("  loss {:.4f}", state.loss);
  if (state.recall_at_1 >= 0) {
    text += fmt::format("  recall@1 {:.3f} @8 {:.3f}", state.recall_at_1, state.recall_at_8);
  }
  return text + fmt::format("  left {}", FormatDuration(state.seconds_left));
}

void PrintReport(const TrainingReport& report, const ObjectSet& objects) {
  const HeldOutRecall &first = report.recall_history.front(), &last = report.recall_history.back();
  if (report.plateau_iteration >= 0) {
    fmt::print(
        "held-out recall reached a plateau at step {}: the training schedule was shortened\n",
        report.plateau_iteration);
  }
  fmt::print("held-out recall@1 {:.3f}, @8 {:.3f}; verifiers' area under the curve {:.3f}\n",
             last.at_1, last.at_8, report.verifier_auc);
  for (size_t i = 0; i < objects.size(); ++i) {
    if (!report.rehearsed[i]) continue;
    fmt::print("  {}, known from the start model: recall@1 {:.3f} before, {:.3f} after\n",
               objects[i]->name, first.object_at_1[i], last.object_at_1[i]);
  }
}

// Adds --set and the options with a name of their own.
void AddTrainArguments(CLI::App& app, TrainArguments& arguments,
                       std::vector<std::string>& training_settings) {
  app.add_option("OBJECT", arguments.training_set.objects,
                 "objects of the catalog (see pickbed list objects); the first word may be the "
                 "estimator to train: descriptor (default), kehl, doumanoglou or wohlhart");
  app.add_option("--objects", arguments.listed, "objects to train for, separated by commas")
      ->delimiter(',');
  app.add_option(
      "--scenario", arguments.training_set.scenario.scenario,
      "train for the objects of this scenario, with its camera, bin, sensor and appearance");
  app.add_option("--bop", arguments.training_set.bop_path,
                 "train for the models of this BOP dataset, with its camera");
  app.add_option(
         "--sensor", arguments.training_set.sensors,
         "sensor profiles for the views of clutter scenes, separated by commas; each view uses one "
         "of them instead of the scenario's sensor; the code book uses the scenario's sensor")
      ->delimiter(',');
  app.add_option("--deep-share", arguments.training_set.deep_share,
                 "share of the clutter scenes that are deep piles of 50 to 140 instances")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  CLI::Option* distractors =
      app.add_option("--distractors", arguments.training_set.distractor_share,
                     "share of the clutter scenes with distractors")
          ->check(CLI::Range(0.0, 1.0))
          ->capture_default_str();
  AddFormerName(app, "--foreign", distractors, arguments.training_set.distractor_share)
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--catalog", arguments.training_set.scenario.catalog,
                 "folder with your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.model_file, "model file to write [models/<objects>.net]");
  app.add_option("--from", arguments.training_set.start_from,
                 "model file to start from; its objects are kept in addition to the named ones");
  app.add_option("--report", arguments.report_folder,
                 "folder of the report page [beside the model file, <model>_report]");
  app.add_flag("--resume", arguments.resume,
               "continue from the checkpoint of an interrupted training");
  app.add_option("--minutes", arguments.max_minutes,
                 "time limit of the whole training, minutes, for at least some minutes per object; "
                 "0 = none")
      ->check(WithoutUpperLimit())
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "random seed; the same seed gives the same model")
      ->capture_default_str();
  app.add_option("--set", training_settings,
                 "change a training setting: KEY=VALUE, from the list below")
      ->allow_extra_args(false);
  app.add_option("--verifier-for", arguments.verifier_for,
                 "train only the verifiers of this estimator (for example ppf) on its own "
                 "candidates; settings: seed, clutter_scenes, views_per_scene, calibration_share "
                 "and verifier.*, for wohlhart, whose network is trained first, also wohlhart.*")
      ->excludes("--minutes")
      ->excludes("--from");
  TrainingOptions defaults = EstimatorNamed("descriptor").make_training()->PatchNetworkOptions();
  app.footer("Training settings and their defaults:\n" +
             WriteSettings([&](SettingsVisitor& v) { defaults.Visit(v); }, true) +
             "\n`pickbed train completion --help` shows the training of shape completion. `pickbed "
             "train verifier --help` shows the training of a verifier on many objects."
             "\nExample: pickbed train rod elbow --minutes 5 --set network.descriptor=64\n"
             "         pickbed train kehl --objects bracket");
}

std::unique_ptr<EstimatorTraining> TrainingOf(const EstimatorRow& row) {
  return row.make_training ? row.make_training() : nullptr;
}

// Removes the method from the names and sets its default settings.
void ChooseMethod(TrainArguments& arguments) {
  std::vector<std::string>& names = arguments.training_set.objects;
  for (const EstimatorRow& row : EstimatorTable()) {
    const auto training = TrainingOf(row);
    if (names.empty() || names.front() != row.name || !training) continue;
    if (training->kind() == TrainingKind::kNone || training->kind() == TrainingKind::kVerifiers) {
      continue;
    }
    arguments.method = row.name;
    CheckInput(arguments.verifier_for.empty() || arguments.verifier_for == row.name,
               fmt::format("train {}: --verifier-for {} trains the verifiers of another estimator; "
                           "give one or the other",
                           row.name, arguments.verifier_for));
    if (training->kind() == TrainingKind::kNetworkAndVerifiers) {
      arguments.verifier_for = row.name;
      CheckInput(
          arguments.max_minutes <= 0 && arguments.training_set.start_from.empty(),
          fmt::format("train {}: takes neither --minutes nor --from; remove them", row.name));
    }
    names.erase(names.begin());
    break;
  }
  names.insert(names.end(), arguments.listed.begin(), arguments.listed.end());
  const auto training = TrainingOf(EstimatorNamed(arguments.method));
  if (training->kind() == TrainingKind::kPatchNetwork) {
    arguments.training = training->PatchNetworkOptions();
  }
  arguments.training.seed = arguments.verifier.seed = arguments.seed;
  arguments.training.max_minutes = arguments.max_minutes;
}

std::unique_ptr<EstimatorTraining> VerifierTrainingOf(const std::string& name) {
  std::vector<std::string> names;
  for (const EstimatorRow& row : EstimatorTable()) {
    auto training = TrainingOf(row);
    if (!training || !training->has_verifier_file()) continue;
    if (row.name == name) return training;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("--verifier-for", name, names));
}

int TrainVerifiers(const TrainArguments& arguments, const TrainingSet& training_set,
                   const std::filesystem::path& file) {
  const EstimatorTraining& training = *arguments.verifier_training;
  const bool has_network = training.kind() == TrainingKind::kNetworkAndVerifiers;
  CheckInput(arguments.report_folder.empty(),
             fmt::format("--report: the verifiers of {} have no report page; remove it",
                         arguments.verifier_for));
  const std::filesystem::path checkpoint = file.string() + ".checkpoint";
  const bool has_checkpoint = has_network && std::filesystem::exists(checkpoint);
  CheckInput(!arguments.resume || has_checkpoint || std::filesystem::exists(file) ||
                 std::filesystem::exists(UnfinishedLibrary(file)),
             NothingToResume(UnfinishedLibrary(file)));
  if (!arguments.resume && has_checkpoint) std::filesystem::remove(checkpoint);
  const auto views = MakeTrainingViews(training_set);
  CatchInterrupts();
  VerifierReport report;
  {
    ProgressLine progress;
    VerifierJob job{*views,
                    arguments.verifier_for,
                    [&](const ObjectSet& objects, const LearnedNetwork& network) {
                      return training.MakeCandidates({objects, *views, network});
                    },
                    file,
                    arguments.resume,
                    SensorNames(training_set),
                    [&](std::string_view object, double share) {
                      progress.Show(fmt::format("{}: {}", object, WholePercentText(share)));
                      return !Interrupted();
                    }};
    if (has_network) {
      job.checkpoint = checkpoint;
      job.network_settings = training.NetworkSettings(training_set.objects);
      job.learn = [&](const std::function<bool(double)>& on_share) {
        return training.TrainNetwork(
            {*views, arguments.verifier.seed, checkpoint, on_share, kThreads});
      };
    }
    report = TrainVerifierLibrary(job, arguments.verifier);
  }
  if (!report.finished) {
    if (report.saved.empty() && has_network) {
      SayStopped(checkpoint, "the network up to its last complete round");
    } else {
      SayStopped(report.saved, fmt::format("{} verifiers{}", report.saved_objects,
                                           has_network ? " and the network" : ""));
    }
    return kExitInterrupted;
  }
  if (has_network) std::filesystem::remove(checkpoint);
  fmt::print("wrote {}; area under the curve {:.3f}\nuse it with --set estimator.model={}\n",
             file.string(), report.mean_auc, file.string());
  return 0;
}

int TrainModel(TrainArguments& arguments, const TrainingSet& training_set,
               const std::filesystem::path& model_file,
               std::chrono::steady_clock::time_point began) {
  const std::filesystem::path checkpoint = model_file.string() + ".checkpoint";
  CheckInput(!arguments.resume || std::filesystem::exists(checkpoint), NothingToResume(checkpoint));
  const auto views = MakeTrainingViews(training_set);
  CatchInterrupts();
  TrainingReport report;
  {
    ProgressLine progress;
    const TrainingJob job{*views,
                          model_file,
                          checkpoint,
                          arguments.resume,
                          arguments.training_set.start_from,
                          SensorNames(training_set),
                          [&](const TrainingProgress& state) {
                            progress.ShowTimed(ProgressText(state), CountText(state));
                            return !Interrupted();
                          },
                          began};
    report = TrainDescriptor(job, arguments.training);
  }
  if (!report.finished) {
    SayStopped(report.has_checkpoint ? checkpoint : "",
               fmt::format("{} steps of the network and {} of {} verifiers", report.kept_steps,
                           report.kept_verifiers, report.new_objects));
    return kExitInterrupted;
  }
  PrintReport(report, training_set.objects);
  std::filesystem::path folder = arguments.report_folder;
  if (folder.empty()) {
    folder = model_file.parent_path() / (model_file.stem().string() + "_report");
  }
  const std::string in_force =
      WriteSettings([&](SettingsVisitor& v) { arguments.training.Visit(v); });
  const bool has_page = SayIfUnwritten(
      WriteTrainingPage(folder, {model_file.stem().string(), SensorNames(training_set), in_force,
                                 report, training_set.objects}));
  std::filesystem::remove(checkpoint);
  fmt::print("report: {}\n", (has_page ? folder / kIndexPage : folder).string());
  fmt::print("wrote {} after {}\nuse it with --set estimator.name={} --set estimator.model={}\n",
             model_file.string(), FormatDuration(report.seconds), arguments.method,
             model_file.string());
  return 0;
}

}  // namespace

int TrainCommand(int argc, char** argv) {
  const auto began = std::chrono::steady_clock::now();  // --minutes includes the preparation
  if (argc > 1 && std::string(argv[1]) == "completion") {
    return TrainCompletionCommand(argc - 1, argv + 1);
  }
  if (argc > 1 && std::string(argv[1]) == "grasps") return TrainGraspsCommand(argc - 1, argv + 1);
  if (argc > 1 && std::string(argv[1]) == "verifier") {
    return TrainVerifierCommand(argc - 1, argv + 1);
  }
  CLI::App app(
      "Trains models on views that are rendered during training. Ctrl-C writes a checkpoint.",
      "pickbed train");
  TrainArguments arguments;
  std::vector<std::string> settings;
  AddTrainArguments(app, arguments, settings);
  if (!ParseArguments(app, argc, argv)) return 0;
  ChooseMethod(arguments);
  if (!arguments.verifier_for.empty()) {
    arguments.verifier_training = VerifierTrainingOf(arguments.verifier_for);
  }
  for (const std::string& assignment : settings) {
    ApplySetting(assignment, [&](SettingsVisitor& v) {
      if (arguments.verifier_for.empty()) return arguments.training.Visit(v);
      arguments.verifier.Visit(v);
      EstimatorTraining& training = *arguments.verifier_training;
      if (training.kind() != TrainingKind::kNetworkAndVerifiers) return;
      v.Group(
          arguments.verifier_for.c_str(),
          [&](SettingsVisitor& g) { training.VisitNetworkOptions(g); }, "of its network");
    });
  }

  const TrainingSet training_set = PlanTrainingSet(arguments.training_set);
  std::filesystem::path model_file = arguments.model_file;
  if (model_file.empty()) {
    const bool usual = arguments.method == "descriptor";
    const std::string name = usual ? training_set.name : arguments.method + "-" + training_set.name;
    model_file = std::filesystem::path("models") / (name + ".net");
  }
  if (model_file.has_parent_path()) MakeFolder(model_file.parent_path());
  RequireWritable(model_file);
  if (!arguments.verifier_for.empty()) return TrainVerifiers(arguments, training_set, model_file);
  return TrainModel(arguments, training_set, model_file, began);
}

}  // namespace pickbed::eval
