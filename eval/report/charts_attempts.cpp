#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>

#include "eval/page/vega.h"
#include "eval/report/charts.h"

namespace pickbed::eval {
namespace {

// Numbers of attempts are from 1 here: "3", or "4-6".
std::string RangeName(int first, int last) {
  return first == last ? std::to_string(first + 1) : fmt::format("{}-{}", first + 1, last + 1);
}

int64_t AllRejected(const ConfigurationReport& configuration) {
  return std::accumulate(configuration.rejected.begin(), configuration.rejected.end(), int64_t{0},
                         [](int64_t sum, const auto& entry) { return sum + entry.second; });
}

// Causes of all configurations, the most frequent first.
std::vector<std::string> CausesOf(std::span<const ConfigurationReport> configurations) {
  std::map<std::string, int64_t> sums;
  for (const ConfigurationReport& configuration : configurations) {
    for (const auto& [cause, count] : configuration.rejected) sums[cause] += count;
  }
  std::vector<std::string> causes;
  for (const auto& [cause, sum] : sums) {
    if (sum > 0) causes.push_back(cause);
  }
  std::stable_sort(causes.begin(), causes.end(),
                   [&](const auto& a, const auto& b) { return sums[a] > sums[b]; });
  return causes;
}

}  // namespace

ReportChart AttemptsChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{"attempts", "Picks as the bin empties",
                    "Share of the attempts that picked, by their number in the bin. The first "
                    "attempt is at the full bin. Bars: 95 % intervals over bins.",
                    ""};
  std::vector<std::string> names;
  for (const AttemptRange& range : configurations[0].attempt_ranges) {
    names.push_back(RangeName(range.first, range.last));
  }
  std::vector<RateCurve> curves;
  for (const ConfigurationReport& configuration : configurations) {
    const std::string series = configurations.size() > 1 ? configuration.name : "picked";
    RateCurve& curve = curves.emplace_back(RateCurve{series, {}});
    for (const AttemptRange& range : configuration.attempt_ranges) {
      curve.rates.push_back(range.picked);
    }
  }
  return RateCurves(std::move(chart), "number of the attempt", "share that picked", names, curves);
}

ReportChart FillChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{
      "fill-level", "Pick success by fill level",
      "Share of the executed grasps that picked, by the fill level of the bin before "
      "the pick: mean height of the surface over the height of the bin. A bin empties "
      "from right to left. Bars: 95 % intervals over bins.",
      ""};
  std::map<double, std::string> names;  // by lower limit
  for (const ConfigurationReport& configuration : configurations) {
    for (const FillBand& band : configuration.summary.by_fill) names[band.fill_min] = band.name();
  }
  std::vector<std::string> x_names;
  for (const auto& [fill_min, name] : names) x_names.push_back(name);
  std::vector<RateCurve> curves;
  for (const ConfigurationReport& configuration : configurations) {
    const std::string series = configurations.size() > 1 ? configuration.name : "pick success";
    RateCurve& curve = curves.emplace_back(RateCurve{series, {}});
    curve.rates.resize(x_names.size());
    for (const FillBand& band : configuration.summary.by_fill) {
      const auto at = std::distance(names.begin(), names.find(band.fill_min));
      curve.rates[static_cast<size_t>(at)] = band.success;
    }
  }
  return RateCurves(std::move(chart), "fill level before the pick, %", "pick success", x_names,
                    curves);
}

ReportChart RejectionsChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{
      "rejections", "Rejected grasp candidates by cause",
      "Summed over all attempts. Candidates that were \"not tried\" were not checked, "
      "because better ones were free; \"outranked\" ones were free but not among "
      "the best.",
      ""};
  const std::vector<std::string> causes = CausesOf(configurations), names = NamesOf(configurations);
  chart.table = {{"cause"}};
  for (const ConfigurationReport& configuration : configurations) {
    const std::string prefix = configurations.size() > 1 ? configuration.name + ": " : "";
    chart.table[0].insert(chart.table[0].end(), {prefix + "candidates", "share"});
  }
  Json values = Json::array();
  for (const std::string& cause : causes) {
    chart.table.push_back({cause});
    for (const ConfigurationReport& configuration : configurations) {
      const auto found = configuration.rejected.find(cause);
      const int64_t count = found == configuration.rejected.end() ? 0 : found->second;
      const int64_t all = std::max<int64_t>(1, AllRejected(configuration));
      const double share = static_cast<double>(count) / static_cast<double>(all);
      chart.table.back().insert(chart.table.back().end(),
                                {std::to_string(count), PercentText(share)});
      values.push_back({{"cause", cause},
                        {"series", configuration.name},
                        {"share", share},
                        {"text", fmt::format("{} ({})", count, PercentText(share))}});
    }
  }
  if (values.empty()) {
    chart.caption = "No grasp candidate was rejected.";
    return chart;
  }
  Json y = Field("cause", "nominal", "");
  y["sort"] = causes;
  y["title"] = nullptr;
  Json encoding{{"y", y}, {"x", PercentField("share", "share of rejected candidates", false)}};
  encoding["x"]["scale"] = {{"domain", {0, 1.3}}};  // with room for the text
  encoding["x"]["axis"]["values"] = {0, 0.25, 0.5, 0.75, 1};
  if (configurations.size() > 1) {
    encoding["yOffset"] = {{"field", "series"}, {"type", "nominal"}, {"sort", names}};
  }
  Json text = encoding;
  encoding["fill"] = SeriesFill("series", names);
  text["text"] = {{"field", "text"}, {"type", "nominal"}};
  Json spec = EmptySpec(values);
  spec["height"] = BarsHeight_px(causes.size(), configurations.size());
  spec["layer"] = {
      {{"mark", {{"type", "bar"}}}, {"encoding", encoding}},
      {{"mark", {{"type", "text"}, {"align", "left"}, {"dx", 5}}}, {"encoding", text}}};
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed::eval
