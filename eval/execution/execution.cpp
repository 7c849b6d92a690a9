#include "eval/execution/execution.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "eval/bop/layout.h"
#include "eval/execution/image_executor.h"
#include "eval/runtime/results_folder.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

// Number of an image in its data set, with the picks that it needs.
struct ImageTask {
  int scene_id = 0, image_id = 0;
  int requested = 0;  // picks of each method
};

std::string HashOfFile(const fs::path& file) {
  const std::string bytes = ReadFileBytes(file);
  return fmt::format("{:016x}", HashBytes(bytes.data(), bytes.size()));
}

// All inputs of an execution, read and checked.
struct Inputs {
  ExecutedScenes scenes;
  std::vector<Method> methods;
  std::vector<ImageTask> images;
  std::string identity;
};

// Whether the instances of an image are the ones of its stored scene, in the same order.
bool HasInstancesOf(const ImageTruth& image, const Scene& scene) {
  return image.infos.size() == scene.objects.size() &&
         std::ranges::equal(image.instances, scene.objects,
                            [](const DatasetInstance& instance, const PosedObject& posed) {
                              return instance.object_id == posed.object + 1;
                            });
}

ExecutedScenes ReadScenes(const Bin& bin, const ObjectSet& objects,
                          const ExecutionOptions& options) {
  const fs::path split = options.dataset / options.split;
  const std::vector<int> ids = SceneIdsOf(options.dataset, options.split);
  CheckInput(!ids.empty(), fmt::format("{}: has no scene folder such as 000001", split.string()));
  ExecutedScenes scenes;
  for (const int id : ids) {
    const fs::path folder = split / SceneFolderName(id);
    StoredScenes stored = ReadStoredScenes(folder, bin, objects);
    SceneTruth truth = ReadSceneTruth(folder, id, ThrowFault);
    CheckInput(truth.unusable.empty(),
               truth.unusable.empty() ? "" : truth.unusable.front() + "; make the dataset again");
    for (const auto& [image_id, image] : truth.images) {
      CheckInput(HasInstancesOf(image, stored.Of(image_id, folder)) && image.X_CW,
                 fmt::format("{}: image {}: {} and {} do not fit together; make the dataset again",
                             folder.string(), image_id, kStoredScenesFile, kSceneTruthFile));
    }
    scenes.emplace(id, ExecutedScene{std::move(truth), std::move(stored)});
  }
  return scenes;
}

std::string MethodName(const fs::path& file, const std::set<std::string>& taken) {
  const std::string name = file.stem().string();
  CheckInput(name.find_first_of(",\"\n") == std::string::npos && !name.empty(),
             fmt::format("{}: the name must not have a comma or a quote", file.string()));
  CheckInput(
      !taken.contains(name),
      fmt::format("{}: another method is also named {}; rename the file", file.string(), name));
  return name;
}

// Text of everything that the picks depend on. The identity of a run covers the files that the
// settings name: gripper, meshes, and the program of a planner.
std::string IdentityOf(const ScenarioSpec& spec, const ObjectSet& objects,
                       const ExecutionOptions& options, const ExecutedScenes& scenes) {
  std::string text = ScenarioText(spec, options.out);
  const std::string of_run = RunIdentity(WithoutEstimator(spec), objects);
  text +=
      fmt::format("# settings and files are {:016x}\n", HashBytes(of_run.data(), of_run.size()));
  for (const auto& [id, scene] : scenes) {
    text +=
        fmt::format("# scene {} is {} {}\n", id, HashOfFile(scene.truth.folder / kStoredScenesFile),
                    HashOfFile(scene.truth.folder / kSceneTruthFile));
  }
  for (const fs::path& file : options.results) {
    text += fmt::format("# method {} is {}\n", file.stem().string(), HashOfFile(file));
  }
  if (options.oracle) text += fmt::format("# method {}\n", kTruePosesMethod);
  return text + fmt::format("# {} picks per image of {}\n", options.picks, options.split);
}

Inputs ReadInputs(const ScenarioSpec& spec, const ObjectSet& objects,
                  const ExecutionOptions& options, const ExecutionListener& listener) {
  CheckInput(options.picks >= 1 && options.jobs >= 1,
             "the numbers of picks and of processes must be at least 1");
  CheckInput(!options.results.empty() || options.oracle,
             "no results file is given, so there is nothing to execute");
  Inputs inputs;
  const Bin bin = BinOf(spec);
  inputs.scenes = ReadScenes(bin, objects, options);
  std::set<std::string> names;
  if (options.oracle) names.insert(kTruePosesMethod);
  for (const fs::path& file : options.results) {
    const std::string name = MethodName(file, names);
    names.insert(name);
    const std::vector<DatasetEstimate> estimates = ReadEstimates(file);
    RequireEstimatesOf(file, estimates, inputs.scenes, bin, static_cast<int>(objects.size()));
    inputs.methods.push_back(MethodOf(name, estimates));
    const std::string missing = MissingImagesText(file, inputs.methods.back(), inputs.scenes);
    if (!missing.empty() && listener.on_warning) listener.on_warning(missing);
  }
  if (options.oracle) {
    inputs.methods.push_back(MethodOf(kTruePosesMethod, OracleEstimates(inputs.scenes)));
  }
  std::vector<bool> is_wanted;
  for (const ObjectSpec& object : spec.objects) is_wanted.push_back(!object.distractor);
  for (const auto& [scene_id, scene] : inputs.scenes) {
    for (const auto& [image_id, image] : scene.truth.images) {
      inputs.images.push_back(
          {scene_id, image_id, RequestedPicks(image, is_wanted, options.picks)});
    }
  }
  inputs.identity = IdentityOf(spec, objects, options, inputs.scenes);
  return inputs;
}

using RowsByImage = std::map<std::pair<int, int>, std::vector<ExecutedPick>>;

// Returns the rows of complete images of an earlier call.
RowsByImage EarlierRows(const Inputs& inputs, const ExecutionOptions& options) {
  const fs::path settings = options.out / kExecutionFile, file = options.out / kPicksFile;
  RowsByImage rows;
  if (!fs::exists(settings) || !fs::exists(file)) return rows;
  const std::string text = ReadFileBytes(file);
  const size_t header = text.find('\n');
  if (header == std::string::npos) return rows;
  for (ExecutedPick& pick : ReadPickRows(text.substr(header + 1))) {
    rows[{pick.scene_id, pick.image_id}].push_back(std::move(pick));
  }
  CheckInput(rows.empty() || ReadFileBytes(settings) == inputs.identity,
             fmt::format("{} has picks of other results, settings or scenes; choose another "
                         "results folder",
                         options.out.string()));
  std::map<std::pair<int, int>, size_t> expected;
  for (const ImageTask& image : inputs.images) {
    expected[{image.scene_id, image.image_id}] = image.requested * inputs.methods.size();
  }
  std::erase_if(rows, [&](const auto& entry) {
    const auto& [image, picks] = entry;
    return !expected.contains(image) || picks.size() != expected.at(image);
  });
  CheckInput(rows.empty() || options.resume,
             fmt::format("{} already has the picks of {} images; resume it, or choose another "
                         "results folder",
                         options.out.string(), rows.size()));
  return rows;
}

std::string RowsText(const RowsByImage& rows) {
  std::string text = HeaderLine(PicksColumns());
  for (const auto& [image, picks] : rows) {
    for (const ExecutedPick& pick : picks) text += PickRow(pick);
  }
  return text;
}

Cluster OutcomeOf(const std::vector<ExecutedPick>& picks) {
  Cluster outcome{0, static_cast<int>(picks.size())};
  for (const ExecutedPick& pick : picks) outcome.hits += pick.success;
  return outcome;
}

}  // namespace

ExecutionReport ExecuteResults(const ScenarioSpec& spec, const ObjectSet& objects,
                               const ExecutionOptions& options, const ExecutionListener& listener) {
  const Inputs inputs = ReadInputs(spec, objects, options, listener);
  const FolderLock lock(options.out);
  RowsByImage rows = EarlierRows(inputs, options);
  WriteFileAtomically(options.out / kExecutionFile, inputs.identity);
  const fs::path file = options.out / kPicksFile;
  WriteFileAtomically(file, RowsText(rows));

  ExecutionProgress progress;
  progress.total = static_cast<int>(inputs.images.size());
  WorkerPlan plan;
  plan.jobs = options.jobs;
  for (int i = 0; i < progress.total; ++i) {
    const ImageTask& image = inputs.images[i];
    const auto known = rows.find({image.scene_id, image.image_id});
    if (known != rows.end()) progress.outcomes.push_back(OutcomeOf(known->second));
    if (known == rows.end() && image.requested > 0) plan.items.push_back(i);
  }
  progress.done = progress.done_before = progress.total - static_cast<int>(plan.items.size());
  plan.start = [&](const WorkerPlan::Say& say) -> WorkerPlan::DoItem {
    auto executor =
        std::make_shared<ImageExecutor>(spec, objects, options.dataset, inputs.scenes,
                                        options.picks, options.out / kLogsFolder, say.warning);
    return [executor, &inputs](int i) {
      const ImageTask& image = inputs.images[i];
      std::string reply;
      for (const ExecutedPick& pick :
           executor->Execute(image.scene_id, image.image_id, inputs.methods)) {
        reply += PickRow(pick);
      }
      return reply;
    };
  };
  plan.on_done = [&](int i, const std::string& reply) {
    const ImageTask& image = inputs.images[i];
    auto& picks = rows[{image.scene_id, image.image_id}] = ReadPickRows(reply);
    AppendToFile(file, reply);
    ++progress.done;
    progress.outcomes.push_back(OutcomeOf(picks));
    if (listener.on_image) listener.on_image(progress);
  };
  plan.on_warning = listener.on_warning;
  plan.stop = listener.stop;
  WorkReport work = RunInWorkers(plan);

  ExecutionReport report;
  for (const Method& method : inputs.methods) report.methods.push_back(method.name);
  report.images = progress.total;
  report.interrupted = work.stopped;
  report.lost = std::move(work.lost);
  if (report.interrupted || !report.lost.empty()) return report;
  WriteFileAtomically(file, RowsText(rows));
  for (auto& [image, picks] : rows) {
    report.picks.insert(report.picks.end(), picks.begin(), picks.end());
  }
  return report;
}

}  // namespace pickbed::eval
