#include <fmt/format.h>

#include "eval/report/charts_impl.h"

namespace pickbed {

std::string RateText(const ReportRate& rate) {
  if (rate.tries == 0) return "-";
  return fmt::format("{:.1f} % [{:.1f}, {:.1f}]", 100 * rate.rate(), 100 * rate.ci95.low,
                     100 * rate.ci95.high);
}

ReportChart SuccessChart(std::span<const PointReport> points) {
  ReportChart chart{"success", "Pick success of all settings",
                    "Share of the executed grasps that brought their part, with 95 % intervals.",
                    ""};
  chart.table = {{"settings", "success [95 %]", "attempts"}};
  Json values = Json::array();
  for (const PointReport& point : points) {
    const RunSummary& s = point.summary;
    const ReportRate rate{s.successes, s.attempts, s.success_ci95};
    chart.table.push_back({point.name, RateText(rate), std::to_string(rate.tries)});
    if (rate.tries == 0) continue;
    values.push_back({{"series", point.name},
                      {"rate", rate.rate()},
                      {"low", rate.ci95.low},
                      {"high", rate.ci95.high},
                      {"text", fmt::format("{} of {}", RateText(rate), rate.tries)}});
  }
  if (values.empty()) {
    chart.caption = "No grasp was executed.";
    return chart;
  }
  Json y = Field("series", "nominal", "");
  y["sort"] = NamesOf(points);
  y["title"] = nullptr;
  const Json x = PercentField("rate", "pick success");
  Json low = x;
  low["field"] = "low";
  Json spec = EmptySpec(values);
  spec["height"] = BarsHeight_px(values.size(), 1);
  spec["layer"] = {{{"mark", {{"type", "rule"}, {"color", "currentColor"}}},
                    {"encoding", {{"y", y}, {"x", low}, {"x2", {{"field", "high"}}}}}},
                   {{"mark", {{"type", "point"}, {"filled", true}, {"size", 80}}},
                    {"encoding",
                     {{"y", y},
                      {"x", x},
                      {"tooltip",
                       {{{"field", "series"}, {"type", "nominal"}},
                        {{"field", "text"}, {"type", "nominal"}}}}}}}};
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed
