#include "eval/pick_forecast.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "eval/few_bins.h"
#include "eval/tolerance_report.h"
#include "grasp/success_rules.h"

namespace pickbed {
namespace {

PickForecast ForecastOf(const std::string& name, const std::vector<JudgedPart>& parts) {
  PickForecast forecast;
  forecast.part = name;
  std::map<int, Cluster> bins;
  for (const JudgedPart& part : parts) {
    for (const JudgedPick& pick : part.picks) {
      Cluster& bin = bins[pick.cluster];
      ++bin.tries;
      bin.hits += pick.success;
      ++forecast.picks;
      forecast.successes += pick.success;
      forecast.expected += SuccessProbability(part.model, pick.X_OtrueObelieved);
      forecast.expected_with_grasp +=
          SuccessProbability(part.model, pick.X_OtrueObelieved, pick.X_OG.value());
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

std::vector<JudgedPick> JudgedPicksOf(std::span<const TrialResult> trials, int object) {
  std::vector<JudgedPick> picks;
  for (const TrialResult& trial : trials) {
    for (const PickRecord& pick : trial.picks) {
      if (!pick.grasp || pick.aimed < 0) continue;
      const HypothesisScore& chosen = pick.hypotheses[pick.chosen];
      if (chosen.instance < 0 || chosen.object != object) continue;
      picks.push_back({chosen.X_OtrueObelieved,
                       pick.outcome.verdicts[static_cast<int>(SuccessRule::kRightPart)],
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
    const ToleranceModel* model = maps.Of(static_cast<int>(i));
    if (model == nullptr) continue;
    JudgedPart part{*model, *objects[i], JudgedPicksOf(trials, static_cast<int>(i))};
    if (part.picks.empty()) continue;
    forecasts.push_back(ForecastOf(objects[i]->name, {part}));
    parts.push_back(std::move(part));
  }
  if (parts.size() > 1) forecasts.push_back(ForecastOf("all parts", parts));
  return forecasts;
}

std::string ForecastText(const std::vector<PickForecast>& forecasts) {
  std::string text;
  for (const PickForecast& f : forecasts) {
    text += fmt::format(
        "Picks of {} by their pose errors: {} of {} succeeded = {:.1f} % [{:.1f}, {:.1f}], the "
        "tolerance map foretells {:.1f} %, knowing the grasps {:.1f} %\n",
        f.part, f.successes, f.picks, 100.0 * f.successes / f.picks, 100 * f.rate_ci95.low,
        100 * f.rate_ci95.high, 100 * f.expected / f.picks, 100 * f.expected_with_grasp / f.picks);
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
    object["part"] = f.part;
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
  std::string csv = "trial,pick,hypothesis,object,instance,p_pick\n";
  for (const TrialResult& trial : trials) {
    for (const PickRecord& pick : trial.picks) {
      for (size_t i = 0; i < pick.hypotheses.size(); ++i) {
        const HypothesisScore& h = pick.hypotheses[i];
        const std::optional<double> chance = maps.PickChance(h);
        if (!chance) continue;
        csv += fmt::format("{},{},{},{},{},{:.4f}\n", trial.trial, pick.pick, i,
                           objects.at(h.object)->name, h.instance, *chance);
      }
    }
  }
  return csv;
}

}  // namespace pickbed
