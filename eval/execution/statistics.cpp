#include "eval/execution/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

namespace pickbed::eval {
namespace {

constexpr char kScorePredictor[] = "score";

using Picks = std::vector<const ExecutedPick*>;

// Adds a pick to the cluster of its scene.
using PickCount = std::function<void(const ExecutedPick& pick, Cluster& scene)>;

// Returns one cluster per scene, in the order of `scenes`.
std::vector<Cluster> ByScene(const Picks& picks, const std::vector<int>& scenes,
                             const PickCount& count) {
  std::vector<Cluster> clusters(scenes.size());
  for (const ExecutedPick* pick : picks) {
    const auto at = std::lower_bound(scenes.begin(), scenes.end(), pick->scene_id);
    count(*pick, clusters[at - scenes.begin()]);
  }
  return clusters;
}

void CountRequested(const ExecutedPick& pick, Cluster& scene) {
  ++scene.samples;
  scene.hits += pick.success;
}

void CountExecuted(const ExecutedPick& pick, Cluster& scene) {
  if (pick.executed()) CountRequested(pick, scene);
}

PredictorAuc AucOf(const OutcomePredictor& predictor, const Picks& picks) {
  std::map<int, std::vector<ScoredOutcome>> by_scene;
  std::vector<ScoredOutcome> all;
  for (const ExecutedPick* pick : picks) {
    if (!pick->executed()) continue;
    double score = predictor.score(*pick);
    if (std::isnan(score)) score = -kInfinity;  // matches no instance
    all.push_back({score, pick->success});
    by_scene[pick->scene_id].push_back(all.back());
  }
  OutcomeClusters clusters;
  for (auto& [scene, outcomes] : by_scene) clusters.push_back(std::move(outcomes));
  PredictorAuc result{predictor.name, Auc(all)};
  if (result.auc.is_known()) result.auc.interval = ClusterBootstrapAuc(clusters);
  return result;
}

MethodStatistics StatisticsOfMethod(const std::string& method, const Picks& picks,
                                    const std::vector<int>& scenes) {
  MethodStatistics statistics;
  statistics.method = method;
  statistics.requested = ClusterRate(ByScene(picks, scenes, CountRequested));
  statistics.executed = ClusterRate(ByScene(picks, scenes, CountExecuted));
  int picks_of_image = 0;
  std::set<FailureReason> reasons;
  for (const ExecutedPick* pick : picks) {
    picks_of_image = std::max(picks_of_image, pick->pick + 1);
    if (!pick->success) reasons.insert(pick->failure);
  }
  for (const FailureReason reason : reasons) {
    const auto count = [reason](const ExecutedPick& pick, Cluster& scene) {
      ++scene.samples;
      scene.hits += !pick.success && pick.failure == reason;
    };
    statistics.failures[reason] = ClusterRate(ByScene(picks, scenes, count));
  }
  for (int number = 0; number < picks_of_image; ++number) {
    const auto count = [number](const ExecutedPick& pick, Cluster& scene) {
      if (pick.pick == number) CountRequested(pick, scene);
    };
    statistics.by_pick.push_back(ClusterRate(ByScene(picks, scenes, count)));
  }
  for (const OutcomePredictor& predictor : OutcomePredictors()) {
    statistics.predictors.push_back(AucOf(predictor, picks));
  }
  return statistics;
}

ConfigurationComparison Compare(const std::string& before, const Picks& picks_before,
                                const std::string& after, const Picks& picks_after,
                                const std::vector<int>& scenes) {
  ConfigurationComparison comparison{before, after, {}};
  comparison.paired.scenes = static_cast<int>(scenes.size());
  const auto add = [&](const char* key, const char* name, const PickCount& count) {
    comparison.paired.statistics.push_back(PairedRate(
        key, name, ByScene(picks_before, scenes, count), ByScene(picks_after, scenes, count)));
  };
  add("requested_picked", "requested picks that succeeded", CountRequested);
  add("pick_success", "executed grasps that succeeded", CountExecuted);
  return comparison;
}

}  // namespace

const std::vector<OutcomePredictor>& OutcomePredictors() {
  static const std::vector<OutcomePredictor> predictors{
      {"vsd", "VSD", "visible surface discrepancy, mean over BOP's ten tolerances",
       [](const ExecutedPick& pick) { return -pick.errors.vsd; }},
      {"mssd", "MSSD", "maximum symmetry-aware surface distance",
       [](const ExecutedPick& pick) { return -pick.errors.mssd_m; }},
      {"mspd", "MSPD", "maximum symmetry-aware projection distance",
       [](const ExecutedPick& pick) { return -pick.errors.mspd_px; }},
      {"add", "ADD", "mean distance of corresponding model points",
       [](const ExecutedPick& pick) { return -pick.errors.add_m; }},
      {"adi", "ADI", "mean distance to the closest model point",
       [](const ExecutedPick& pick) { return -pick.errors.adi_m; }},
      {kScorePredictor, "score", "score of the method, as in its results file",
       [](const ExecutedPick& pick) { return pick.score; }},
      {"visible", "visible fraction", "visible fraction of the matched instance",
       [](const ExecutedPick& pick) { return pick.visible_fraction; }},
  };
  return predictors;
}

ExecutionStatistics StatisticsOf(const std::vector<std::string>& methods,
                                 const std::vector<ExecutedPick>& picks) {
  ExecutionStatistics statistics;
  std::set<int> ids;
  std::set<std::pair<int, int>> images;
  std::map<std::string, Picks> by_method;
  Picks all;
  for (const ExecutedPick& pick : picks) {
    ids.insert(pick.scene_id);
    images.insert({pick.scene_id, pick.image_id});
    by_method[pick.method].push_back(&pick);
    all.push_back(&pick);
  }
  const std::vector<int> scenes(ids.begin(), ids.end());
  statistics.scenes = static_cast<int>(scenes.size());
  statistics.images = static_cast<int>(images.size());
  statistics.picks = static_cast<int>(picks.size());
  for (const std::string& method : methods) {
    statistics.methods.push_back(StatisticsOfMethod(method, by_method[method], scenes));
  }
  for (const OutcomePredictor& predictor : OutcomePredictors()) {
    if (std::string(predictor.name) == kScorePredictor) continue;
    statistics.predictors.push_back(AucOf(predictor, all));
  }
  for (size_t i = 1; i < methods.size(); ++i) {
    statistics.paired.push_back(
        Compare(methods[0], by_method[methods[0]], methods[i], by_method[methods[i]], scenes));
  }
  return statistics;
}

}  // namespace pickbed::eval
