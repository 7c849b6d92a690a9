#include <fmt/format.h>

#include <algorithm>

#include "eval/page/vega.h"
#include "eval/report/charts.h"

namespace pickbed::eval {
namespace {

// Width relative to the longest bar; leaves space for the text at its end.
constexpr double kRoomForText = 1.35;

ReportRate RateOf(const BudgetShares& shares, FailureReason failure) {
  return {shares.budget[failure], shares.budget.asked(), shares[failure]};
}

std::string FailureLabel(const FailureRow& row) {
  return fmt::format("{}: {}", StageName(row.stage), row.name);
}

bool AnyFailure(std::span<const ConfigurationReport> configurations, FailureReason failure) {
  for (const ConfigurationReport& configuration : configurations) {
    if (configuration.attempts.budget[failure] > 0) return true;
  }
  return false;
}

TableCells FailureTableCells(std::span<const ConfigurationReport> configurations) {
  TableCells cells{{"stage", "reason", "meaning"}};
  for (const ConfigurationReport& configuration : configurations) {
    cells[0].push_back(configurations.size() > 1 ? configuration.name : "attempts");
    cells[0].push_back("share [95 %]");
  }
  const auto add = [&](std::vector<std::string> row, auto rate_of) {
    for (const ConfigurationReport& configuration : configurations) {
      const ReportRate rate = rate_of(configuration.attempts);
      row.push_back(std::to_string(rate.hits));
      row.push_back(RateText(rate));
    }
    cells.push_back(std::move(row));
  };
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone || !AnyFailure(configurations, row.failure)) continue;
    add({std::string(StageName(row.stage)), std::string(row.name), std::string(row.help)},
        [&](const BudgetShares& shares) { return RateOf(shares, row.failure); });
  }
  add({"done", "picked", "an instance was picked"}, [](const BudgetShares& shares) {
    return ReportRate{shares.budget.picked, shares.budget.asked(), shares.picked};
  });
  return cells;
}

// One bar per reason and configuration.
struct FailureBars {
  Json values = Json::array();
  std::vector<std::string> labels;  // labels of the reasons
  double longest = 0;
  bool few = false;  // some bar has too few bins for an interval
};

FailureBars BarsOf(std::span<const ConfigurationReport> configurations) {
  FailureBars bars;
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone || !AnyFailure(configurations, row.failure)) continue;
    bars.labels.push_back(FailureLabel(row));
    for (const ConfigurationReport& configuration : configurations) {
      const ReportRate rate = RateOf(configuration.attempts, row.failure);
      const double end = rate.ci95.is_known() ? rate.ci95.high : rate.rate();
      bars.few = bars.few || !rate.ci95.is_known();
      bars.longest = std::max(bars.longest, end);
      bars.values.push_back(
          {{"reason", bars.labels.back()},
           {"series", configuration.name},
           {"share", rate.rate()},
           {"low", rate.ci95.is_known() ? rate.ci95.low : end},
           {"high", end},
           {"means", row.help},
           {"text", fmt::format("{} ({})", rate.hits, PercentText(rate.rate()))}});
    }
  }
  return bars;
}

}  // namespace

ReportChart FailureChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{"failures", "Failed picks by reason",
                    "Each attempt at a bin with instances requests one instance. It picks the "
                    "instance or fails for one reason, which belongs to one stage. Attempts "
                    "without a grasp count as failed. Lines: 95 % intervals over bins.",
                    ""};
  chart.table = FailureTableCells(configurations);
  const FailureBars bars = BarsOf(configurations);
  if (bars.labels.empty()) {
    chart.caption += " No pick failed.";
    return chart;
  }
  if (bars.few) SayTooFewBins(chart.caption);
  Json spec = EmptySpec(bars.values);
  const std::vector<std::string> names = NamesOf(configurations);
  Json y = Field("reason", "nominal", "");
  y["sort"] = bars.labels;
  y["title"] = nullptr;
  Json encoding{{"y", y}, {"x", PercentField("share", "share of attempts", false)}};
  encoding["x"]["scale"] = {{"domain", {0, kRoomForText * bars.longest}}};
  Json text_encoding = encoding, line_encoding = encoding;
  text_encoding["x"]["field"] = "high";
  line_encoding["x"]["field"] = "low";
  line_encoding["x2"] = {{"field", "high"}};
  encoding["fill"] = SeriesFill("series", names);
  encoding["tooltip"] = {{{"field", "reason"}, {"type", "nominal"}},
                         {{"field", "means"}, {"type", "nominal"}},
                         {{"field", "text"}, {"type", "nominal"}, {"title", "attempts"}}};
  text_encoding["text"] = {{"field", "text"}, {"type", "nominal"}};
  if (configurations.size() > 1) {
    const Json offset{{"field", "series"}, {"type", "nominal"}, {"sort", names}};
    encoding["yOffset"] = text_encoding["yOffset"] = line_encoding["yOffset"] = offset;
  }
  spec["height"] = BarsHeight_px(bars.labels.size(), configurations.size());
  spec["layer"] = {
      {{"mark", {{"type", "bar"}}}, {"encoding", encoding}},
      {{"mark", {{"type", "rule"}, {"color", "currentColor"}, {"strokeWidth", 1.5}}},
       {"encoding", line_encoding}},
      {{"mark", {{"type", "text"}, {"align", "left"}, {"dx", 5}}}, {"encoding", text_encoding}}};
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed::eval
