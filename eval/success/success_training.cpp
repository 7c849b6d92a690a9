#include "eval/success/success_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "eval/runtime/process_pool.h"
#include "eval/stats/roc.h"
#include "grasp/completed/success_network.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

// Examples of one group and the chances that a network without them gives.
struct PredictedGroup {
  int group = 0;
  GraspExamples examples;
  std::vector<double> chances;
};

std::filesystem::path FileOf(const SuccessTrainingJob& job, int group) {
  return job.data_folder / fmt::format("group_{:04}.grasps", group);
}

// Returns the groups that have a file in the folder, in order.
std::vector<int> GroupsIn(const SuccessTrainingJob& job) {
  std::vector<int> groups;
  for (const auto& entry : std::filesystem::directory_iterator(job.data_folder)) {
    int group = 0;
    const std::string name = entry.path().filename();
    if (std::sscanf(name.c_str(), "group_%d", &group) == 1 && FileOf(job, group) == entry.path()) {
      groups.push_back(group);
    }
  }
  std::ranges::sort(groups);
  return groups;
}

// Makes the examples of the groups without a file. Returns whether all groups have one.
bool MakeMissingExamples(const SuccessTrainingJob& job, const SuccessTrainingOptions& options) {
  WorkerPlan plan;
  int done = 0;
  for (int group = options.first_group; group < options.first_group + options.groups; ++group) {
    if (std::filesystem::exists(FileOf(job, group))) {
      // A file that does not fit is refused before the other groups are made, which takes hours.
      LoadGraspExamples(FileOf(job, group), ExamplesKey(group, options.examples));
      ++done;
    } else {
      plan.items.push_back(group);
    }
  }
  const int done_before = done;
  if (job.on_group) job.on_group(done, options.groups, done_before);
  if (plan.items.empty()) return true;
  plan.jobs = job.jobs;
  plan.start = [&](const WorkerPlan::Say&) -> WorkerPlan::DoItem {
    return [&](int group) -> std::string {
      const GraspExamples examples = MakeGraspExamples(group, options.examples, [] {});
      SaveGraspExamples(FileOf(job, group), ExamplesKey(group, options.examples), examples);
      return {};
    };
  };
  plan.on_done = [&](int, const std::string&) {
    if (job.on_group) job.on_group(++done, options.groups, done_before);
  };
  plan.stop = job.stop;
  const WorkReport report = RunInWorkers(plan);
  if (!report.lost.empty()) {
    const LostItem& lost = report.lost.front();
    throw std::runtime_error(
        fmt::format("group {}: {}; repeat the command to make it again", lost.item, lost.why));
  }
  return !report.stopped;
}

SuccessNetwork Fit(const std::vector<const GraspExamples*>& groups,
                   const SuccessTrainingOptions& options) {
  PerceptronExamples all{grasp::kSuccessInputs, {}, {}};
  for (const GraspExamples* group : groups) {
    all.values.insert(all.values.end(), group->inputs.begin(), group->inputs.end());
    all.label.insert(all.label.end(), group->success.begin(), group->success.end());
  }
  PerceptronOptions perceptron = options.perceptron;
  perceptron.max_input = SuccessNetwork::kMaxInput;
  FittedPerceptron fitted = FitPerceptron(all, perceptron, options.seed);
  SuccessNetwork network{{}, std::move(fitted.mean), std::move(fitted.scale), {}};
  for (FittedPerceptron::Layer& layer : fitted.layers) {
    network.layers.push_back({std::move(layer.weights), std::move(layer.bias)});
  }
  return network;
}

// Predicts the groups of each fold by a network that was trained on the others. Two neighbouring
// groups, one of each kind, are in the same fold.
void CrossPredict(const SuccessTrainingOptions& options, std::vector<PredictedGroup>& groups) {
  const auto fold_of = [&](const PredictedGroup& group) { return group.group / 2 % options.folds; };
  for (int fold = 0; fold < options.folds; ++fold) {
    std::vector<const GraspExamples*> others;
    for (const PredictedGroup& group : groups) {
      if (fold_of(group) != fold) others.push_back(&group.examples);
    }
    if (others.size() == groups.size()) continue;  // fewer groups than folds
    const SuccessNetwork network = Fit(others, options);
    for (PredictedGroup& group : groups) {
      if (fold_of(group) != fold) continue;
      const std::vector<float>& inputs = group.examples.inputs;
      for (size_t i = 0; i < group.examples.success.size(); ++i) {
        group.chances.push_back(network.Chance(
            {inputs.data() + i * grasp::kSuccessInputs, size_t{grasp::kSuccessInputs}}));
      }
    }
  }
}

SuccessQuality QualityOfKind(GroupKind kind, const std::vector<PredictedGroup>& groups) {
  SuccessQuality quality;
  quality.kind = kind;
  ForecastClusters forecasts;
  OutcomeClusters clusters;
  std::vector<ScoredOutcome> outcomes;
  int successes = 0, best = 0, any = 0;
  for (const PredictedGroup& group : groups) {
    if (KindOf(group.group) != kind || group.examples.success.empty()) continue;
    forecasts.emplace_back();
    clusters.emplace_back();
    struct Image {
      double best_chance = -1;
      bool best = false, any = false;
    };
    std::map<int, Image> images;
    for (size_t i = 0; i < group.chances.size(); ++i) {
      const double chance = group.chances[i];
      const bool success = group.examples.success[i] != 0;
      forecasts.back().push_back({chance, success});
      clusters.back().push_back({chance, success});
      outcomes.push_back({chance, success});
      successes += success;
      Image& image = images[group.examples.image[i]];
      image.any |= success;
      if (chance > image.best_chance) image = {chance, success, image.any};
    }
    for (const auto& [number, image] : images) {
      best += image.best;
      any += image.any;
    }
    quality.images += static_cast<int>(images.size());
  }
  quality.grasps = static_cast<int>(outcomes.size());
  if (outcomes.empty()) return quality;
  quality.base_rate = static_cast<double>(successes) / quality.grasps;
  quality.auc = Auc(outcomes).auc;
  quality.auc_ci95 = ClusterBootstrapAuc(clusters);
  quality.calibration_error = QualityOf(forecasts).calibration_error;
  quality.best = static_cast<double>(best) / quality.images;
  quality.any = static_cast<double>(any) / quality.images;
  return quality;
}

}  // namespace

void SuccessTrainingOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed of the fit");
  v.Integer("first_group", first_group, {0, 100000}, "number of the first group");
  v.Integer("groups", groups, {4, 10000}, "number of groups of bins; half of them are deep bins");
  v.Integer("folds", folds, {2, 100},
            "parts that are predicted by a network trained on the others");
  v.Group(
      "examples", [this](SettingsVisitor& g) { examples.Visit(g); }, "grasps that are executed");
  v.Group(
      "perceptron", [this](SettingsVisitor& g) { perceptron.Visit(g); }, "fit of the network");
}

SuccessTrainingReport TrainSuccessNetwork(const SuccessTrainingJob& job,
                                          const SuccessTrainingOptions& options) {
  CheckSettings("SuccessTrainingOptions", options);
  MakeFolder(job.data_folder);
  SuccessTrainingReport report;
  if (!MakeMissingExamples(job, options)) return report;
  std::vector<PredictedGroup> groups;
  for (const int group : GroupsIn(job)) {
    const int index = group - options.first_group;
    const bool is_asked = index >= 0 && index < options.groups;
    const std::string key = is_asked ? ExamplesKey(group, options.examples) : "";
    groups.push_back({group, LoadGraspExamples(FileOf(job, group), key), {}});
    report.grasps += static_cast<int>(groups.back().examples.success.size());
  }
  CrossPredict(options, groups);
  std::string figures;
  for (const GroupKind kind : {GroupKind::kShallow, GroupKind::kDeep}) {
    const SuccessQuality& quality = report.quality.emplace_back(QualityOfKind(kind, groups));
    figures +=
        fmt::format("# {}: {} grasps, held-out AUC {:.3f}\n",
                    kind == GroupKind::kDeep ? "deep" : "shallow", quality.grasps, quality.auc);
  }
  std::vector<const GraspExamples*> all;
  for (const PredictedGroup& group : groups) all.push_back(&group.examples);
  SuccessNetwork network = Fit(all, options);
  SuccessTrainingOptions copy = options;  // Visit() is not const
  network.training = WriteSettings([&](SettingsVisitor& v) { copy.Visit(v); }) + figures;
  SaveSuccessNetwork(job.model_file, network);
  report.finished = true;
  return report;
}

}  // namespace pickbed::eval
