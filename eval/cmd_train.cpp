#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "eval/bop/models.h"
#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/interrupt.h"
#include "eval/progress.h"
#include "eval/training_page.h"
#include "perception/estimators/wohlhart.h"
#include "perception/pose_estimator.h"
#include "perception/torch_model_file.h"
#include "perception/training.h"
#include "perception/verifier_library.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "sim/convex_pieces.h"
#include "sim/view_source.h"

namespace pickbed {
namespace {

// Camera distances to learn from, over that of the scenario.
constexpr double kNearest = 0.88;
constexpr double kFarthest = 1.15;
// Parts of this size fit the default cell; without a scenario the cell grows and shrinks with them.
constexpr double kUsualDiameter_m = 0.095;

struct TrainArguments {
  std::vector<std::string> objects;  // the first may be the method's name
  std::vector<std::string> listed;   // of --objects
  std::string method = "descriptor";
  std::string bop_path;              // a BOP data set: all of its models, for its camera
  ScenarioArguments scenario;        // optional: camera, bin, sensor, looks and parts
  std::vector<std::string> sensors;  // of the piles; empty = the scenario's
  double foreign_share = 0.3;        // of the piles, in which shapes lie that are no parts
  std::string model_file;
  std::string start_from;
  std::string report_folder;
  bool resume = false;
  uint64_t seed = 0;
  double max_minutes = 0;
  TrainingOptions training;
  std::string verifier_for;  // an estimator: its verifiers alone are trained
  VerifierTrainingOptions verifier;
  WohlhartBinOptions wohlhart;
};

// Diameter of a part below which training is refused, px.
constexpr int kLeastPixels = 10;

// What is learned, and the cell that it is learned for.
struct Lesson {
  std::string name;
  ScenarioSpec spec;
  bool has_cell = false;               // of a scenario; else cells of a size that suits each part
  std::vector<SensorProfile> sensors;  // of the piles; empty = the scenario's
  double foreign_share = 0;            // of the piles, in which shapes lie that are no parts
  ObjectSet objects;
  std::optional<CameraIntrinsics> camera;  // of a data set, instead of the scenario's
};

// The parts that the model to begin with knows are learned on with the others, so that none is
// forgotten.
void AddKnownParts(const TrainArguments& arguments, Lesson& lesson) {
  const ObjectCatalog catalog = OpenCatalog(arguments.scenario.catalog);
  const std::filesystem::path file = arguments.start_from;
  for (const ModelObject& known : LoadModel(file).info.objects) {
    const auto is_known = [&](const auto& object) { return object->name == known.name; };
    if (std::any_of(lesson.objects.begin(), lesson.objects.end(), is_known)) continue;
    const std::vector<std::string> names = catalog.Names();
    CheckInput(std::find(names.begin(), names.end(), known.name) != names.end(),
               fmt::format("{}: it knows part '{}', which is in no catalog, so that it would be "
                           "forgotten; pass --catalog or a scenario that has it",
                           file.string(), known.name));
    const auto object = catalog.Load(known.name);
    CheckInput(object->mesh_hash == known.mesh_hash,
               fmt::format("{}: the mesh of part '{}' has changed since training; name the part "
                           "to learn it anew",
                           file.string(), known.name));
    lesson.objects.push_back(object);
  }
}

// Said before minutes of rendering: of a part of few pixels there is nothing to learn.
void RequireVisibleParts(const Lesson& lesson) {
  const double distance_m = lesson.spec.camera.eye_m.norm();
  for (const auto& object : lesson.objects) {
    const double pixels =
        CameraOf(lesson.spec).intrinsics.fx * object->diameter_m / (kFarthest * distance_m);
    CheckInput(pixels >= kLeastPixels,
               fmt::format("part '{}' is {:.1f} px large at {:.2f} m, and {} px are the least to "
                           "learn from; bring the camera nearer (camera.eye_m), raise "
                           "camera.focal_px or check the mesh's unit",
                           object->name, pixels, kFarthest * distance_m, kLeastPixels));
  }
}

Lesson PlanLesson(const TrainArguments& arguments) {
  Lesson lesson;
  if (!arguments.scenario.scenario.empty()) {
    LoadedScenario loaded = LoadScenarioArguments(arguments.scenario);
    ObjectSet learned;
    for (size_t i = 0; i < loaded.objects.size(); ++i) {
      if (!loaded.spec.objects[i].foreign) learned.push_back(loaded.objects[i]);
    }
    lesson = {loaded.name, std::move(loaded.spec), true, {}, 0, std::move(learned), {}};
  }
  if (!arguments.bop_path.empty()) {
    CheckInput(arguments.objects.empty() && lesson.objects.empty(),
               "--bop takes the place of OBJECT and --scenario; name one or the other");
    const std::filesystem::path root = arguments.bop_path;
    lesson.name = (std::filesystem::absolute(root) / ".")
                      .lexically_normal()
                      .parent_path()
                      .filename()
                      .string();
    lesson.objects = bop::LoadParts(root).objects;
    const auto camera = bop::ReadDatasetCamera(root / "camera.json", bop::ThrowFault);
    if (camera) lesson.camera = camera->intrinsics;
  }
  if (!arguments.objects.empty()) {
    const ObjectCatalog catalog = OpenCatalog(arguments.scenario.catalog);
    lesson.objects.clear();
    lesson.name.clear();
    for (const std::string& name : arguments.objects) {
      lesson.objects.push_back(catalog.Load(name));
      lesson.name += lesson.name.empty() ? name : "-" + name;
    }
  }
  CheckInput(!lesson.objects.empty(),
             "nothing to learn: name objects of the catalog or pass --scenario FILE");
  for (const std::string& name : arguments.sensors) {
    lesson.sensors.push_back(LoadSensorProfile(name));
  }
  lesson.foreign_share = arguments.foreign_share;
  if (!arguments.start_from.empty()) AddKnownParts(arguments, lesson);
  if (lesson.has_cell) RequireVisibleParts(lesson);
  return lesson;
}

// Those of the scenario; a lamp that it leaves where it is varies all the same.
AppearanceRanges LearnedLooks(const AppearanceRanges& of_scenario) {
  const AppearanceRanges fixed = FixedAppearance(), varied;
  AppearanceRanges looks = of_scenario;
  for (Span AppearanceRanges::*span : {&AppearanceRanges::lamp_x_m, &AppearanceRanges::lamp_y_m,
                                       &AppearanceRanges::lamp_z_m, &AppearanceRanges::ambient}) {
    if (looks.*span == fixed.*span) looks.*span = varied.*span;
  }
  return looks;
}

std::unique_ptr<LabelledViewSource> MakeViews(const Lesson& lesson) {
  ViewSourceOptions options;
  options.sensor =
      BlameKey(lesson.spec, "sensor", [&] { return LoadSensorProfile(lesson.spec.sensor); });
  options.pile_sensors = lesson.sensors;
  options.foreign_share = lesson.foreign_share;
  options.looks = LearnedLooks(lesson.spec.appearance);
  options.camera = lesson.camera.value_or(CameraOf(lesson.spec).intrinsics);
  options.bin = BinOf(lesson.spec);
  // A cell's camera stands still, but parts lie higher or lower and cells are built to a hand's
  // width.
  const double distance_m = lesson.spec.camera.eye_m.norm();
  options.distance_min_m = kNearest * distance_m;
  options.distance_max_m = kFarthest * distance_m;
  if (!lesson.has_cell) options.for_diameter_m = kUsualDiameter_m;
  return MakeSimViewSource(WithConvexPieces(lesson.objects), options);
}

// As recorded in the model.
std::string SensorNames(const Lesson& lesson) {
  if (lesson.sensors.empty()) return lesson.spec.sensor;
  std::vector<std::string> names;
  for (const SensorProfile& sensor : lesson.sensors) names.push_back(sensor.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string ProgressText(const TrainingProgress& state) {
  std::string text = fmt::format("{} {}/{}", state.phase, state.done, state.total);
  if (state.loss > 0) text += fmt::format("  loss {:.4f}", state.loss);
  if (state.recall_at_1 >= 0) {
    text += fmt::format("  recall@1 {:.3f} @8 {:.3f}", state.recall_at_1, state.recall_at_8);
  }
  return text + fmt::format("  left {}", FormatDuration(state.seconds_left));
}

void PrintReport(const TrainingReport& report, const ObjectSet& objects) {
  const HeldOutRecall &first = report.recall_history.front(), &last = report.recall_history.back();
  if (report.plateau_iteration >= 0) {
    fmt::print("held-out recall stayed on a plateau at step {}: the schedule was cut short\n",
               report.plateau_iteration);
  }
  fmt::print("held-out recall@1 {:.3f}, @8 {:.3f}; verifiers' area under the curve {:.3f}\n",
             last.at_1, last.at_8, report.verifier_auc);
  for (size_t i = 0; i < objects.size(); ++i) {
    if (!report.rehearsed[i]) continue;
    fmt::print("  {}, known before: recall@1 {:.3f} before, {:.3f} after\n", objects[i]->name,
               first.part_at_1[i], last.part_at_1[i]);
  }
}

// "key=value" of --set, and the options that have a name of their own.
void AddTrainArguments(CLI::App& app, TrainArguments& arguments,
                       std::vector<std::string>& training_settings) {
  app.add_option("OBJECT", arguments.objects,
                 "parts of the catalog (pickbed list objects); before them may stand the estimator "
                 "that learns: descriptor (by default), kehl, doumanoglou, wohlhart");
  app.add_option("--objects", arguments.listed, "the parts, with commas")->delimiter(',');
  app.add_option("--scenario", arguments.scenario.scenario,
                 "learn the parts of this scenario, for its camera, bin, sensor and looks");
  app.add_option("--bop", arguments.bop_path,
                 "learn the models of this BOP data set, for its camera");
  app.add_option(
         "--sensor", arguments.sensors,
         "profiles, one of which sees each view of a pile, instead of the scenario's alone; "
         "a code book stays that of the scenario's sensor")
      ->delimiter(',');
  app.add_option("--foreign", arguments.foreign_share,
                 "share of the piles in which shapes lie that are no parts")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--catalog", arguments.scenario.catalog, "folder of your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.model_file, "model file [models/<objects>.pt]");
  app.add_option("--from", arguments.start_from,
                 "model to begin with; the parts that it knows are kept beside those named");
  app.add_option("--report", arguments.report_folder,
                 "folder of the report page [beside the model file, <model>_report]");
  app.add_flag("--resume", arguments.resume, "go on from the checkpoint of a stopped training");
  app.add_option("--minutes", arguments.max_minutes, "time limit in minutes, 0 = none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "same seed, same model")->capture_default_str();
  app.add_option("--set", training_settings, "change a setting of training, key=value")
      ->allow_extra_args(false);
  app.add_option(
         "--verifier-for", arguments.verifier_for,
         "train the verifiers of this estimator alone, e.g. ppf, on its own candidates; its "
         "settings are seed, piles, views_per_pile, calibration_share and verifier.*, and for "
         "wohlhart, whose network is learned before them, wohlhart.*")
      ->excludes("--minutes")
      ->excludes("--from");
  TrainingOptions defaults;
  app.footer("Settings of training and their defaults:\n" +
             WriteSettings([&](SettingsVisitor& v) { defaults.Visit(v); }, true) +
             "\nExample: pickbed train rod elbow --minutes 5 --set network.descriptor=64\n"
             "         pickbed train kehl --objects bracket");
}

// Takes the method from the names, and gives the settings its defaults.
void ChooseMethod(TrainArguments& arguments) {
  std::vector<std::string>& names = arguments.objects;
  for (const EstimatorRow& row : EstimatorTable()) {
    const bool learns = row.training != nullptr || row.learn != nullptr;
    if (!learns || names.empty() || names.front() != row.name) continue;
    arguments.method = row.name;
    if (row.learn != nullptr) {
      arguments.verifier_for = row.name;
      CheckInput(
          arguments.max_minutes <= 0 && arguments.start_from.empty(),
          fmt::format("train {}: takes neither --minutes nor --from; leave them out", row.name));
    }
    names.erase(names.begin());
    break;
  }
  names.insert(names.end(), arguments.listed.begin(), arguments.listed.end());
  for (const EstimatorRow& row : EstimatorTable()) {
    if (arguments.method == row.name && row.training) arguments.training = row.training();
  }
  arguments.training.seed = arguments.verifier.seed = arguments.seed;
  arguments.training.max_minutes = arguments.max_minutes;
}

const EstimatorRow& RowWithCandidates(const std::string& name) {
  std::vector<std::string> names;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (row.candidates == nullptr) continue;
    if (row.name == name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("--verifier-for", name, names));
}

int TrainVerifiers(const TrainArguments& arguments, const Lesson& lesson,
                   const std::filesystem::path& file) {
  const EstimatorRow& row = RowWithCandidates(arguments.verifier_for);
  const std::filesystem::path checkpoint = file.string() + ".checkpoint";
  if (!arguments.resume) std::filesystem::remove(checkpoint);
  const auto views = MakeViews(lesson);
  CatchInterrupts();
  VerifierReport report;
  {
    ProgressLine progress;
    VerifierJob job{*views,
                    arguments.verifier_for,
                    [&](const ObjectSet& objects, const LearnedNetwork& network) {
                      return row.candidates({objects, *views, network});
                    },
                    file,
                    arguments.resume,
                    SensorNames(lesson),
                    [&](std::string_view part, double share) {
                      progress.Show(fmt::format("{}: {:.0f} %", part, 100 * share));
                      return !Interrupted();
                    }};
    if (row.learn != nullptr) {
      job.learn = [&](const std::function<bool(double)>& on_share) {
        return row.learn({*views, arguments.wohlhart, arguments.seed, checkpoint, on_share});
      };
    }
    report = TrainVerifierLibrary(job, arguments.verifier);
  }
  if (!report.finished) {
    fmt::print(stderr,
               "pickbed: stopped; {} holds the parts that are done, the same command with "
               "--resume goes on\n",
               file.string());
    return kExitInterrupted;
  }
  std::filesystem::remove(checkpoint);
  fmt::print("wrote {}; area under the curve {:.3f}\nuse it with --set estimator.model={}\n",
             file.string(), report.mean_auc, file.string());
  return 0;
}

void SayStopped(const TrainingReport& report, const std::filesystem::path& checkpoint) {
  if (!report.has_checkpoint) {
    fmt::print(stderr, "pickbed: stopped before the first step; nothing is written\n");
  } else {
    fmt::print(stderr, "pickbed: stopped; {} is written, the same command with --resume goes on\n",
               checkpoint.string());
  }
}

int TrainModel(TrainArguments& arguments, const Lesson& lesson,
               const std::filesystem::path& model_file) {
  const std::filesystem::path checkpoint = model_file.string() + ".checkpoint";
  CheckInput(!arguments.resume || std::filesystem::exists(checkpoint),
             fmt::format("no checkpoint {} to resume from; leave out --resume to start anew",
                         checkpoint.string()));
  const auto views = MakeViews(lesson);
  CatchInterrupts();
  TrainingReport report;
  {
    ProgressLine progress;
    const TrainingJob job{*views,
                          model_file,
                          checkpoint,
                          arguments.resume,
                          arguments.start_from,
                          SensorNames(lesson),
                          [&](const TrainingProgress& state) {
                            progress.Show(ProgressText(state));
                            return !Interrupted();
                          }};
    report = TrainDescriptor(job, arguments.training);
  }
  if (!report.finished) {
    SayStopped(report, checkpoint);
    return kExitInterrupted;
  }
  PrintReport(report, lesson.objects);
  std::filesystem::path folder = arguments.report_folder;
  if (folder.empty()) {
    folder = model_file.parent_path() / (model_file.stem().string() + "_report");
  }
  const std::string in_force =
      WriteSettings([&](SettingsVisitor& v) { arguments.training.Visit(v); });
  WriteTrainingPage(
      folder, {model_file.stem().string(), SensorNames(lesson), in_force, report, lesson.objects});
  std::filesystem::remove(checkpoint);
  fmt::print("report: {}\n", (folder / "index.html").string());
  fmt::print("wrote {} after {}\nuse it with --set estimator.name={} --set estimator.model={}\n",
             model_file.string(), FormatDuration(report.seconds), arguments.method,
             model_file.string());
  return 0;
}

}  // namespace

int TrainCommand(int argc, char** argv) {
  CLI::App app("Learns parts from views that are rendered on the fly; Ctrl-C keeps a checkpoint.",
               "pickbed train");
  TrainArguments arguments;
  std::vector<std::string> settings;
  AddTrainArguments(app, arguments, settings);
  if (!ParseArguments(app, argc, argv)) return 0;
  ChooseMethod(arguments);
  for (const std::string& assignment : settings) {
    ApplySetting(assignment, [&](SettingsVisitor& v) {
      if (arguments.verifier_for.empty()) return arguments.training.Visit(v);
      arguments.verifier.Visit(v);
      v.Group(
          "wohlhart", [&](SettingsVisitor& g) { arguments.wohlhart.Visit(g); }, "of wohlhart");
    });
  }

  const Lesson lesson = PlanLesson(arguments);
  std::filesystem::path model_file = arguments.model_file;
  if (model_file.empty()) {
    const bool usual = arguments.method == "descriptor";
    const std::string name = usual ? lesson.name : arguments.method + "-" + lesson.name;
    model_file = std::filesystem::path("models") / (name + ".pt");
  }
  if (model_file.has_parent_path()) MakeFolder(model_file.parent_path());
  RequireWritable(model_file);
  if (!arguments.verifier_for.empty()) return TrainVerifiers(arguments, lesson, model_file);
  return TrainModel(arguments, lesson, model_file);
}

}  // namespace pickbed
