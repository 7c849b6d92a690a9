#include "eval/tolerance/pick_forecast.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "eval/stats/statistics.h"
#include "eval/tolerance/report.h"
#include "grasp/outcome.h"

namespace pickbed::eval {
namespace {

PickForecast ForecastOf(const std::string& name, const std::vector<JudgedPart>& parts) {
  PickForecast forecast;
  forecast.part = name;
  std::map<int, Cluster> bins;
  for (const JudgedPart& part : parts) {
    for (const JudgedPick& pick : part.picks) {
      Cluster& bin = bins[pick.cluster];
      ++bin.samples;
      bin.hits += pick.success;
      ++forecast.picks;
      forecast.successes += pick.success;
      forecast.expected += SuccessProbability(part.model, pick.X_OE);
      forecast.expected_with_grasp += SuccessProbability(part.model, pick.X_OE, pick.X_OG.value());
    }
  }
  forecast.bins = static_cast<int>(bins.size());
  std::vector<Cluster> clusters;
  for (const auto& [trial, cluster] : bins) clusters.push_back(cluster);
  forecast.rate_ci95 = ClusterInterval(clusters);
  forecast.predictors = JudgePredictors(parts);
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
  json["auc_ci95"] = {predictor.auc.interval.low, predictor.auc.interval.high};
  return json;
}

}  // namespace

std::vector<JudgedPick> JudgedPicksOf(std::span<const TrialResult> trials, ObjectId object) {
  std::vector<JudgedPick> picks;
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& pick : trial.attempts) {
      if (!pick.grasp || pick.matched_instance < 0) continue;
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
  std::vector<JudgedPart> parts;
  for (size_t i = 0; i < objects.size(); ++i) {
    const ToleranceModel* model = maps.Of(ObjectId(i));
    if (model == nullptr) continue;
    JudgedPart part{*model, *objects[i], JudgedPicksOf(trials, ObjectId(i))};
    if (part.picks.empty()) continue;
    forecasts.push_back(ForecastOf(objects[i]->name, {part}));
    parts.push_back(std::move(part));
  }
  if (parts.size() > 1) forecasts.push_back(ForecastOf("all objects", parts));
  return forecasts;
}

std::string ForecastText(const std::vector<PickForecast>& forecasts) {
  std::string text;
  for (const PickForecast& f : forecasts) {
    text += fmt::format(
        "Picks of {} by their pose errors: {} of {} succeeded = {} {}; the tolerance map predicts "
        "{}, or {} if the grasps are known\n",
        f.part, f.successes, f.picks, PercentText(f.successes, f.picks), IntervalText(f.rate_ci95),
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
    object["object"] = f.part;
    object["bins"] = f.bins;
    object["picks"] = f.picks;
    object["successes"] = f.successes;
    object["success_ci95"] = {f.rate_ci95.low, f.rate_ci95.high};
    object["expected_successes"] = f.expected;
    object["expected_successes_with_grasp"] = f.expected_with_grasp;
    object["scores"] = nlohmann::ordered_json::array();
    for (const Predictor& p : f.predictors) object["scores"].push_back(PredictorObject(p));
    json.push_back(std::move(object));
  }
  return json.dump(2);
}

std::string PickChancesCsv(std::span<const TrialResult> trials, const ObjectSet& objects,
                           const ToleranceMaps& maps) {
  std::string csv = "trial,attempt,hypothesis,object,instance,p_pick\n";
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& pick : trial.attempts) {
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
