#include "eval/tolerance/pick_forecast.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "eval/metrics/interval_json.h"
#include "eval/stats/statistics.h"
#include "eval/tolerance/report.h"
#include "grasp/outcome.h"

namespace pickbed::eval {
namespace {

PickForecast ForecastOf(const std::string& name, const std::vector<JudgedObject>& judged_objects) {
  PickForecast forecast;
  forecast.object = name;
  std::map<int, Cluster> bins;
  for (const JudgedObject& object : judged_objects) {
    for (const JudgedPick& pick : object.picks) {
      Cluster& bin = bins[pick.cluster];
      ++bin.samples;
      bin.hits += pick.success;
      ++forecast.picks;
      forecast.successes += pick.success;
      forecast.expected += SuccessProbability(object.model, pick.X_OE);
      forecast.expected_with_grasp +=
          SuccessProbability(object.model, pick.X_OE, pick.X_OG.value());
    }
  }
  forecast.bins = static_cast<int>(bins.size());
  std::vector<Cluster> clusters;
  for (const auto& [trial, cluster] : bins) clusters.push_back(cluster);
  forecast.rate_ci95 = ClusterInterval(clusters);
  forecast.predictors = JudgePredictors(judged_objects);
  return forecast;
}

nlohmann::ordered_json PredictorObject(const Predictor& predictor) {
  nlohmann::ordered_json json;
  json["score"] = predictor.name;
  if (!predictor.auc.is_known()) {
    json["auc"] = nullptr;
    return json;
  }
  json["auc"] = predictor.auc.auc;
  AddInterval(json, "auc_ci95", predictor.auc.interval);
  return json;
}

}  // namespace

std::vector<JudgedPick> JudgedPicksOf(std::span<const TrialResult> trials, ObjectId object) {
  std::vector<JudgedPick> picks;
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& pick : trial.attempts) {
      if (!pick.grasp || pick.matched_instance < 0 || pick.chosen < 0) continue;
      const HypothesisRecord& chosen = pick.hypotheses[pick.chosen];
      if (chosen.instance < 0 || chosen.object != object) continue;
      picks.push_back({chosen.X_OE,
                       pick.outcome.verdicts[static_cast<int>(SuccessRule::kRightInstance)],
                       trial.trial, chosen.X_WO.inverse() * pick.grasp->X_WG});
    }
  }
  return picks;
}

std::vector<PickForecast> ForecastsOf(std::span<const TrialResult> trials, const ObjectSet& objects,
                                      const ToleranceMaps& maps) {
  std::vector<PickForecast> forecasts;
  std::vector<JudgedObject> judged_objects;
  for (size_t i = 0; i < objects.size(); ++i) {
    const ToleranceModel* model = maps.Of(ObjectId(i));
    if (model == nullptr) continue;
    JudgedObject object{*model, *objects[i], JudgedPicksOf(trials, ObjectId(i))};
    if (object.picks.empty()) continue;
    forecasts.push_back(ForecastOf(objects[i]->name, {object}));
    judged_objects.push_back(std::move(object));
  }
  if (judged_objects.size() > 1) forecasts.push_back(ForecastOf("all objects", judged_objects));
  return forecasts;
}

std::string ForecastText(const std::vector<PickForecast>& forecasts) {
  std::string text;
  for (const PickForecast& f : forecasts) {
    text += fmt::format(
        "Picks of {} by their pose errors: {} of {} succeeded = {}; the tolerance map predicts "
        "{}, or {} if the grasps are known\n",
        f.object, f.successes, f.picks, RateText({f.successes, f.picks, f.rate_ci95}),
        PercentText(f.expected / f.picks), PercentText(f.expected_with_grasp / f.picks));
    text += PredictorText(f.predictors, fmt::format("{} bins", f.bins));
    const std::string few = FewBinsText(f.bins);
    if (!few.empty()) text += "  " + few + "\n";
  }
  return text;
}

std::string ForecastJson(const std::vector<PickForecast>& forecasts) {
  auto json = nlohmann::ordered_json::array();
  for (const PickForecast& f : forecasts) {
    nlohmann::ordered_json object;
    object["object"] = f.object;
    object["bins"] = f.bins;
    object["picks"] = f.picks;
    object["successes"] = f.successes;
    AddInterval(object, "success_ci95", f.rate_ci95);
    object["expected_successes"] = f.expected;
    object["expected_successes_with_grasp"] = f.expected_with_grasp;
    object["scores"] = nlohmann::ordered_json::array();
    for (const Predictor& p : f.predictors) object["scores"].push_back(PredictorObject(p));
    json.push_back(std::move(object));
  }
  return json.dump(2);
}

ResultColumns ForecastKeys() {
  ResultColumns keys;
  const auto add = [&](const ResultColumns& more) { AddColumns(more, keys); };
  add({
      {"object", "name of the object, or 'all objects'"},
      {"bins", "number of bins with such a pick"},
      {"picks", "number of executed picks at a pose that matches an instance of the object"},
      {"successes", "number of these picks that delivered the target"},
  });
  add(IntervalKeys("success_ci95", "95 % interval of successes / picks; bins are the units"));
  add({
      {"expected_successes", "number of successes predicted by the tolerance map"},
      {"expected_successes_with_grasp", "the same, if the executed grasps are known"},
      {"scores[].score", "name of a score that predicts success"},
      {"scores[].auc",
       "probability that the score ranks a successful pick above a failed one; null if all picks "
       "had the same outcome"},
  });
  add(IntervalKeys("scores[].auc_ci95", "95 % interval of auc"));
  return keys;
}

ResultColumns PickChancesColumns() {
  return {
      {"trial", "number of the trial"},
      {"attempt", "number of the attempt in its trial"},
      {"hypothesis", "number of the hypothesis in its attempt, highest score first"},
      {"object", "name of the object"},
      {"instance", "matched instance, -1 = none"},
      {"p_pick", "predicted probability that a pick at this pose succeeds", "0..1"},
  };
}

std::string PickChancesCsv(std::span<const TrialResult> trials, const ObjectSet& objects,
                           const ToleranceMaps& maps) {
  std::string csv = HeaderLine(PickChancesColumns());
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& pick : trial.attempts) {
      if (!pick.has_own_image()) continue;
      for (size_t i = 0; i < pick.hypotheses.size(); ++i) {
        const HypothesisRecord& h = pick.hypotheses[i];
        const std::optional<double> chance = maps.PickChance(h);
        if (!chance) continue;
        csv += fmt::format("{},{},{},{},{},{:.4f}\n", trial.trial, pick.attempt, i,
                           objects.at(h.object)->name, h.instance, *chance);
      }
    }
  }
  return csv;
}

}  // namespace pickbed::eval
