#include <fmt/format.h>

#include "eval/report/charts_impl.h"

namespace pickbed {
namespace {

Json DiagonalLayer() {
  const Json ends =
      Json::array({{{"confidence", 0}, {"rate", 0}}, {{"confidence", 1}, {"rate", 1}}});
  return {{"data", {{"values", ends}}},
          {"mark",
           {{"type", "line"}, {"color", "currentColor"}, {"opacity", 0.5}, {"strokeDash", {2, 3}}}},
          {"encoding",
           {{"x", PercentField("confidence", "stated confidence")},
            {"y", PercentField("rate", "share of right poses")}}}};
}

}  // namespace

ReportChart CalibrationChart(std::span<const PointReport> points) {
  ReportChart chart{"calibration", "Is the confidence to be believed?",
                    "Reported poses in bins of their confidence against the share of them that is "
                    "right. On the dotted line 90 % sure means right nine times in ten; below it "
                    "the estimator is too sure. Bars: 95 % intervals, with scenes as units. "
                    "Expected calibration error:",
                    ""};
  chart.table = {{"settings", "mean confidence", "right [95 %]", "poses"}};
  Json values = Json::array();
  for (const PointReport& point : points) {
    const Calibration& calibration = point.calibration;
    if (calibration.poses == 0) continue;
    chart.caption += fmt::format("{} {}{:.3f} of {} poses", values.empty() ? "" : ";",
                                 points.size() > 1 ? point.name + " " : "",
                                 calibration.expected_error, calibration.poses);
    for (const ConfidenceBin& bin : calibration.bins) {
      const std::string text = fmt::format("{} of {}", RateText(bin.right), bin.right.tries);
      chart.table.push_back({point.name, fmt::format("{:.1f} %", 100 * bin.mean_confidence),
                             RateText(bin.right), std::to_string(bin.right.tries)});
      values.push_back({{"confidence", bin.mean_confidence},
                        {"rate", bin.right.rate()},
                        {"low", bin.right.ci95.low},
                        {"high", bin.right.ci95.high},
                        {"series", point.name},
                        {"text", text}});
    }
  }
  if (values.empty()) {
    chart.caption = "No pose was reported.";
    return chart;
  }
  chart.caption += ".";
  Json spec = EmptySpec(values);
  Json layers = CurveLayers(PercentField("confidence", "stated confidence"),
                            PercentField("rate", "share of right poses"), NamesOf(points));
  layers.erase(0);  // bars alone: bins may be far apart
  layers.insert(layers.begin(), DiagonalLayer());
  spec["height"] = 300;
  spec["layer"] = layers;
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed
