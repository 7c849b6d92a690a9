#include "eval/cli/image/cmd_estimate_bop.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <span>

#include "eval/bop/estimate_dataset.h"
#include "eval/bop/layout.h"
#include "eval/bop/targets.h"
#include "eval/cli/commands.h"
#include "eval/cli/image/estimate_arguments.h"
#include "eval/estimate/partial_estimates.h"
#include "eval/frames/image_estimator.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/runtime/results_folder.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

constexpr const char* kLocalisation = "localisation";
constexpr const char* kDetection = "detection";
// Behind what a line on standard error says about kept estimates. Messages of errors get the option
// where they are printed.
constexpr const char* kHowToResume = "; resume it (--resume)";

std::string DataSetName(const std::string& path) {
  return (std::filesystem::absolute(path) / ".")
      .lexically_normal()
      .parent_path()
      .filename()
      .string();
}

// Returns the bin of a data set that `pickbed dataset make` wrote; nullopt for others.
std::optional<Bin> StoredBin(const BopArguments& bop) {
  const std::filesystem::path file = std::filesystem::path(bop.path) / kDatasetScenarioFile;
  if (bop.without_cell || !std::filesystem::exists(file)) return std::nullopt;
  return BinOf(LoadScenario(file));
}

DatasetTask TaskOf(const BopArguments& bop) {
  return bop.task == kDetection ? DatasetTask::kDetection : DatasetTask::kLocalisation;
}

// Each task has its own default folder, because the information given to the estimator changes the
// poses.
std::filesystem::path BopFolder(const BopArguments& bop, const std::string& out,
                                const std::string& what) {
  const std::string task = TaskOf(bop) == DatasetTask::kDetection ? "-detection" : "";
  return OutFolder(out, DataSetName(bop.path), what + task);
}

ScenarioSpec BopSettings(const BopArguments& bop, const ScenarioRequest& arguments,
                         double min_score) {
  CheckInput(arguments.scenario.empty() && !arguments.trials,
             "--bop replaces SCENARIO and --trials; give one or the other");
  CheckInput(std::filesystem::is_directory(bop.path),
             fmt::format("--bop {}: is no folder; give a folder with models/ and {}/", bop.path,
                         bop.split));
  ScenarioSpec spec = ImageSettings(arguments, min_score);
  if (!bop.roi.empty()) spec.roi = ParseRegion(bop.roi);
  return spec;
}

std::string HashOf(const std::string& text) {
  return fmt::format("{:016x}", HashBytes(text.data(), text.size()));
}

// Returns the names and contents of the models.
std::string ModelsText(const std::filesystem::path& folder) {
  std::string text;
  for (const char* extension : {".json", ".ply", ".png", ".jpg"}) {
    for (const std::string& stem : StemsIn(folder, extension)) {
      text += stem + extension + HashOf(ReadFileBytes(folder / (stem + extension)));
    }
  }
  return text;
}

// Returns a text of everything but the pixels that the estimates depend on, in the form of
// RunIdentity().
std::string IdentityOf(const BopArguments& bop, const ScenarioSpec& spec) {
  const std::filesystem::path root = bop.path;
  ScenarioSpec copy = spec;
  std::string text = WriteSettingsKey([&](SettingsVisitor& v) { copy.Visit(v); });
  text += EstimatorFilesText(spec);
  text += fmt::format("# task is {}\n# split is {}\n", bop.task, bop.split);
  std::string images, cameras;
  for (const auto& [scene_id, targets] : TargetsOf(root, bop.split).scenes) {
    cameras += ReadFileBytes(root / bop.split / SceneFolderName(scene_id) / kSceneCameraFile);
    for (const auto& [image_id, target] : targets) {
      images += fmt::format("image {} {}", scene_id, image_id);
      for (const auto& [object_id, count] : target.counts) {
        images += fmt::format(" {}:{}", object_id, count);
      }
    }
  }
  text += fmt::format("# images of the dataset {}\n", HashOf(images));
  text += fmt::format("# cameras of the dataset {}\n", HashOf(cameras));
  if (!spec.roi.mask.empty()) {
    text += fmt::format("# mask {}\n", HashOf(ReadFileBytes(spec.roi.mask)));
  }
  text += fmt::format("# meshes of the dataset {}\n", HashOf(ModelsText(root / "models")));
  const std::filesystem::path cell = root / kDatasetScenarioFile;
  const bool has_cell = !bop.without_cell && Exists(cell);
  return text +
         fmt::format("# cell of the dataset {}\n", has_cell ? HashOf(ReadFileBytes(cell)) : "none");
}

}  // namespace

void AddBopArguments(CLI::App& app, BopArguments& bop) {
  auto* bop_option =
      app.add_option("--bop", bop.path, "folder of a BOP dataset; replaces SCENARIO");
  app.add_option("--split", bop.split, "scene folder of the BOP dataset")
      ->capture_default_str()
      ->needs(bop_option);
  app.add_option("--task", bop.task,
                 "information given to the estimator for each BOP image: which objects to find and "
                 "how many of each (localisation), or none (detection; the default results folder "
                 "then ends in -detection)")
      ->check(CLI::IsMember({kLocalisation, kDetection}))
      ->capture_default_str()
      ->needs(bop_option);
  app.add_flag("--without-cell", bop.without_cell,
               "do not use the bin and the camera poses that `pickbed dataset make` stored; table, "
               "floor and bin are then looked for in each image")
      ->needs(bop_option);
  app.add_flag("--resume", bop.resume,
               "continue interrupted estimates of a BOP dataset; needs the same arguments")
      ->needs(bop_option);
}

int ExplainBop(const BopArguments& bop, const ScenarioRequest& arguments,
               const std::vector<std::string>& estimators, const std::string& image,
               const std::string& out) {
  CheckInput(!bop.resume, "--resume: a page of --explain shows one image; leave --resume out");
  ScenarioSpec spec = BopSettings(bop, arguments, kMinImageScore);
  spec.estimator = ExplainedEstimator(arguments, estimators, spec.estimator);
  const std::filesystem::path folder = BopFolder(bop, out, "-bop-explain");
  ExplanationPage page;
  {
    constexpr int kThreads = 1;
    ProgressLine progress;
    EstimateDatasetOptions options{spec.estimator, spec.refiner, spec.seed, kThreads, TaskOf(bop)};
    options.bin = StoredBin(bop);
    options.region = spec.roi;
    page = ExplainTarget(
        bop.path, bop.split, options, image, folder, [&](const EstimateDatasetProgress& state) {
          progress.Show(fmt::format("{}: {}", state.what, WholePercentText(state.share)));
        });
  }
  SayWhereExplained(page);
  return 0;
}

int EstimateBop(const BopArguments& bop, const ScenarioRequest& arguments,
                const std::vector<std::string>& estimators, const std::string& out, int threads) {
  // BOP ranks poses by score; a pose with a low score costs nothing.
  constexpr double kEvenDoubtful = 0;
  ScenarioSpec spec = BopSettings(bop, arguments, kEvenDoubtful);
  CheckInput(estimators.size() < 2,
             "--bop writes the estimates of one estimator; name only one with --estimator");
  const std::vector<ComparedEstimator> named =
      NamedEstimators(arguments, estimators, spec.estimator);
  RequireModes(spec, named);
  spec.estimator = named.front().spec;
  const std::filesystem::path folder = BopFolder(bop, out, "-estimate");
  const FolderLock lock(folder);
  PartialEstimates files(
      folder, fmt::format("{}_{}-{}", spec.estimator.name, DataSetName(bop.path), bop.split));
  files.Begin(IdentityOf(bop, spec), bop.resume);
  CatchInterrupts();
  DatasetEstimates result;
  const auto kept = [&]() -> std::string {
    if (files.finished().empty()) return "no image was processed";
    return fmt::format("the estimates of {} of {} images are in {}", files.finished().size(),
                       result.images, files.partial_csv().string());
  };
  try {
    ProgressLine progress;
    EstimateDatasetOptions options{spec.estimator, spec.refiner, spec.seed, threads, TaskOf(bop)};
    options.log_dir = folder / kLogsFolder;
    options.bin = StoredBin(bop);
    options.region = spec.roi;
    options.finished = files.finished();
    options.on_image = [&](const DatasetImageNote& note,
                           std::span<const DatasetEstimate> estimates) {
      files.Add(note, estimates);
    };
    options.stop = Interrupted;
    options.on_warning = [&](const std::string& line) { progress.Note(line); };
    EstimateDataset(
        bop.path, bop.split, options, result, [&](const EstimateDatasetProgress& state) {
          progress.Show(fmt::format("{}: {}", state.what, WholePercentText(state.share)));
        });
  } catch (const InputError& error) {
    if (files.finished().empty()) throw;
    throw InputError(fmt::format("{}; {}; resume it", error.what(), kept()));
  } catch (const std::exception&) {
    if (!files.finished().empty()) fmt::print(stderr, "pickbed: {}{}\n", kept(), kHowToResume);
    throw;
  }
  if (result.done < result.images && Interrupted()) {
    fmt::print(stderr, "pickbed: interrupted; {}{}\n", kept(),
               files.finished().empty() ? "" : kHowToResume);
    return kExitInterrupted;
  }
  files.Finish();
  fmt::print(
      "{} estimates in {}, and the warnings of each image in {}\nscore them with pickbed score "
      "--bop {} --split {} {}\n{}",
      files.poses(), files.csv().string(), files.images_csv().string(), bop.path, bop.split,
      files.csv().string(),
      TaskOf(bop) == DatasetTask::kLocalisation
          ? "of its scores, AP is comparable only after --task detection\n"
          : "");
  return 0;
}

}  // namespace pickbed::eval
