#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "eval/page/vega.h"
#include "eval/report/charts.h"

namespace pickbed::eval {
ReportChart CalibrationChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{
      "calibration", "Calibration of the score",
      "Reported poses grouped by score, against the share of right poses in each group. On "
      "the dotted line, a score of 90 % is right nine times in ten; below it the estimator is "
      "overconfident. Bars: 95 % intervals over bins. Expected calibration error:",
      ""};
  chart.table = {{"settings", "mean score", "right [95 %]", "poses"}};
  std::vector<CalibrationCurve> curves;
  bool some = false;
  for (const ConfigurationReport& configuration : configurations) {
    CalibrationCurve& curve = curves.emplace_back(CalibrationCurve{configuration.name, {}});
    const Calibration& calibration = configuration.calibration;
    if (calibration.poses == 0) continue;
    chart.caption += fmt::format("{} {}{:.3f} of {} poses", some ? ";" : "",
                                 configurations.size() > 1 ? configuration.name + " " : "",
                                 calibration.expected_error, calibration.poses);
    some = true;
    for (const ConfidenceBin& bin : calibration.bins) {
      curve.points.push_back({bin.mean_confidence, bin.right});
    }
  }
  if (!some) {
    chart.caption = "No pose was reported.";
    return chart;
  }
  chart.caption += ".";
  return CalibrationCurves(std::move(chart), "reported score", "share of right poses", curves);
}

namespace {

// Share of the picks that the tolerance maps expect to succeed; nullopt without a map.
std::optional<double> ForecastRate(const RunSummary& summary) {
  if (summary.forecasts.empty() || summary.forecasts.back().picks == 0) return std::nullopt;
  const PickForecast& all = summary.forecasts.back();
  return all.expected_with_grasp / all.picks;
}

}  // namespace

ReportChart SuccessChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{"success", "Pick success of all settings",
                    "Share of the executed grasps that picked the instance, with 95 % intervals.",
                    ""};
  chart.table = {{"settings", "success [95 %]", "attempts"}};
  const bool forecast =
      std::any_of(configurations.begin(), configurations.end(),
                  [](const auto& report) { return ForecastRate(report.summary).has_value(); });
  if (forecast) {
    chart.caption +=
        " Open diamonds: forecast of the tolerance maps, from the error of the executed pose and "
        "the grasp.";
    chart.table[0].push_back("forecast");
  }
  Json values = Json::array();
  bool few = false;
  for (const ConfigurationReport& configuration : configurations) {
    const RunSummary& s = configuration.summary;
    const ReportRate rate{s.successes, s.executed_grasps, s.success_ci95};
    chart.table.push_back({configuration.name, RateText(rate), std::to_string(rate.samples)});
    const std::optional<double> expected = ForecastRate(s);
    if (forecast) chart.table.back().push_back(expected ? PercentText(*expected) : "");
    if (rate.samples == 0) continue;
    values.push_back({{"series", configuration.name}});
    AddRate(rate, values.back());
    if (expected) values.back()["forecast"] = *expected;
    few = few || !rate.ci95.is_known();
  }
  if (values.empty()) {
    chart.caption = "No grasp was executed.";
    return chart;
  }
  if (few) SayTooFewBins(chart.caption);
  Json y = Field("series", "nominal", "");
  y["sort"] = NamesOf(configurations);
  y["title"] = nullptr;
  const Json x = PercentField("rate", "pick success");
  Json low = x;
  low["field"] = "low";
  Json spec = EmptySpec(values);
  spec["height"] = BarsHeight_px(values.size(), 1);
  spec["layer"] = {
      WithInterval({{"mark", {{"type", "rule"}, {"color", "currentColor"}}},
                    {"encoding", {{"y", y}, {"x", low}, {"x2", {{"field", "high"}}}}}}),
      {{"mark", {{"type", "point"}, {"filled", true}, {"size", 80}}},
       {"encoding",
        {{"y", y},
         {"x", x},
         {"tooltip",
          {{{"field", "series"}, {"type", "nominal"}},
           {{"field", "text"}, {"type", "nominal"}}}}}}}};
  if (forecast) {
    Json x_forecast = x;
    x_forecast["field"] = "forecast";
    spec["layer"].push_back({{"transform", {{{"filter", "isValid(datum.forecast)"}}}},
                             {"mark", {{"type", "point"}, {"shape", "diamond"}, {"size", 110}}},
                             {"encoding", {{"y", y}, {"x", x_forecast}}}});
  }
  chart.spec = spec.dump();
  return chart;
}

namespace {

struct VisibilityCurve {
  std::string series;
  const ConfigurationReport* configuration;
  ReportRate BandRates::*rate;
};

ReportChart CurvesOf(ReportChart chart, const std::string& y_title,
                     const std::vector<VisibilityCurve>& curves,
                     const std::vector<VisibleBand>& bands) {
  std::vector<std::string> names;
  for (const VisibleBand& band : bands) names.push_back(band.name());
  std::vector<RateCurve> rates;
  for (const VisibilityCurve& curve : curves) {
    RateCurve& of_series = rates.emplace_back(RateCurve{curve.series, {}});
    of_series.rates.resize(bands.size());
    for (const BandRates& of_band : curve.configuration->bands) {
      const auto place = std::find(bands.begin(), bands.end(), of_band.band) - bands.begin();
      of_series.rates[place] = of_band.*curve.rate;
    }
  }
  return RateCurves(std::move(chart), "visible fraction of the instance, %", y_title, names, rates);
}

constexpr const char* kRecallCaption =
    "Recall: share of the visible instances with a right reported pose (MSSD below a tenth of the "
    "diameter).";
constexpr const char* kTargetRecallCaption =
    "Target recall: share of the targets with a right reported pose (MSSD below a tenth of the "
    "diameter). Other instances in view do not count.";
constexpr const char* kPickCaption =
    "Pick success: share of the executed grasps that picked the instance, by its visible fraction.";
constexpr const char* kTargetCaption =
    "Share of the attempts at a target that picked it; an attempt without a grasp did not.";
constexpr const char* kBandCaption = "Bars: 95 % intervals over bins.";

std::vector<VisibilityCurve> OfEach(std::span<const ConfigurationReport> configurations,
                                    ReportRate BandRates::*rate) {
  std::vector<VisibilityCurve> curves;
  for (const ConfigurationReport& configuration : configurations)
    curves.push_back({configuration.name, &configuration, rate});
  return curves;
}

bool HasTargets(std::span<const ConfigurationReport> configurations) {
  for (const ConfigurationReport& configuration : configurations) {
    for (const BandRates& band : configuration.bands) {
      if (band.targets.samples > 0) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<ReportChart> VisibilityCharts(std::span<const ConfigurationReport> configurations) {
  std::vector<ReportChart> charts;
  const bool has_targets = HasTargets(configurations);
  const std::string recall = has_targets ? "target recall" : "recall";
  const std::vector<VisibleBand> bands = BandsOfAll(configurations);
  const char* recall_caption = has_targets ? kTargetRecallCaption : kRecallCaption;
  if (configurations.size() == 1) {
    const ConfigurationReport* configuration = configurations.data();
    charts.push_back(
        CurvesOf({"visibility",
                  fmt::format("{} and pick success by visible fraction",
                              has_targets ? "Target recall" : "Recall"),
                  fmt::format("{} {} {}", recall_caption, kPickCaption, kBandCaption), ""},
                 "share",
                 {{recall, configuration, &BandRates::recall},
                  {"pick success", configuration, &BandRates::picks}},
                 bands));
  } else {
    charts.push_back(CurvesOf(
        {"recall", fmt::format("{} by visible fraction", has_targets ? "Target recall" : "Recall"),
         fmt::format("{} {}", recall_caption, kBandCaption), ""},
        recall, OfEach(configurations, &BandRates::recall), bands));
    charts.push_back(CurvesOf({"pick-success", "Pick success by visible fraction",
                               fmt::format("{} {}", kPickCaption, kBandCaption), ""},
                              "pick success", OfEach(configurations, &BandRates::picks), bands));
  }
  if (has_targets) {
    charts.push_back(CurvesOf({"target-picked", "Targets picked by visible fraction",
                               fmt::format("{} {}", kTargetCaption, kBandCaption), ""},
                              "targets picked", OfEach(configurations, &BandRates::targets),
                              bands));
  }
  return charts;
}

ReportChart HiddenShareChart(std::span<const ConfigurationReport> configurations) {
  std::vector<ValueCurve> curves;
  for (const ConfigurationReport& configuration : configurations) {
    ValueCurve curve{configurations.size() > 1 ? configuration.name : "this run", {}};
    for (const HiddenBand& band : configuration.summary.hidden) {
      if (band.picked.samples == 0) continue;
      const double rate = 100 * band.picked.rate();
      const Interval& ci95 = band.picked.ci95;
      ValuePoint point{50 * (band.hidden_min + band.hidden_max), rate, rate, rate};
      if (ci95.is_known()) point.low = 100 * ci95.low, point.high = 100 * ci95.high;
      curve.points.push_back(point);
    }
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  for (const PublishedCurve& published : TargoCurves()) {
    ValueCurve& curve = curves.emplace_back(ValueCurve{published.method, {}});
    for (int band = 0; band < kHiddenBands; ++band) {
      const double rate = 100 * published.success[band];
      curve.points.push_back({100.0 * (band + 0.5) / 10, rate, rate, rate});
    }
  }
  std::string caption = "Targets picked by hidden share, beside published curves.";
  for (const std::string& sentence : HiddenShareNote()) caption += " " + sentence;
  return ValueCurves(
      {"hidden-share", "Targets picked by hidden share, and published curves", caption, ""},
      "hidden share of the target, %", "targets picked, %", curves, 100);
}

}  // namespace pickbed::eval
