#include <fmt/format.h>

#include <algorithm>

#include "eval/report/charts_impl.h"

namespace pickbed {
namespace {

struct Curve {
  std::string series;
  const PointReport* point;
  ReportRate BandRates::*rate;
};

ReportChart CurvesOf(ReportChart chart, const std::string& y_title,
                     const std::vector<Curve>& curves) {
  Json values = Json::array();
  std::vector<std::string> names, bands;
  chart.table = {{"visible"}};
  for (const BandRates& band : curves.front().point->bands) {
    bands.push_back(band.name);
    chart.table.push_back({band.name});
  }
  for (const Curve& curve : curves) {
    names.push_back(curve.series);
    chart.table[0].push_back(curve.series + " [95 %]");
    chart.table[0].push_back("of");
    for (size_t i = 0; i < bands.size(); ++i) {
      const ReportRate& rate = curve.point->bands[i].*curve.rate;
      chart.table[i + 1].push_back(RateText(rate));
      chart.table[i + 1].push_back(std::to_string(rate.tries));
      if (rate.tries == 0) continue;
      values.push_back({{"band", bands[i]},
                        {"series", curve.series},
                        {"rate", rate.rate()},
                        {"low", rate.ci95.low},
                        {"high", rate.ci95.high},
                        {"text", fmt::format("{} of {}", RateText(rate), rate.tries)}});
    }
  }
  if (values.empty()) {
    chart.caption += " There was nothing to count.";
    return chart;
  }
  Json spec = EmptySpec(values);
  Json x = Field("band", "ordinal", "visible fraction of the part");
  x["sort"] = bands;
  x["scale"] = {{"domain", bands}};
  x["axis"] = {{"labelAngle", 0}};
  spec["height"] = 260;
  spec["layer"] = CurveLayers(x, PercentField("rate", y_title), names);
  chart.spec = spec.dump();
  return chart;
}

constexpr const char* kRecallCaption =
    "Recall: share of the parts in view of which a pose was reported that is right (MSSD below a "
    "tenth of the diameter).";
constexpr const char* kPickCaption =
    "Pick success: share of the executed grasps that brought their part, by how much of it was in "
    "view.";
constexpr const char* kBandCaption = "Shaded: 95 % intervals, with scenes as units.";

}  // namespace

std::vector<ReportChart> VisibilityCharts(std::span<const PointReport> points) {
  if (points.size() == 1) {
    const PointReport* point = points.data();
    return {CurvesOf(
        {"visibility", "Recall and pick success by visible fraction",
         fmt::format("{} {} {}", kRecallCaption, kPickCaption, kBandCaption), ""},
        "share",
        {{"recall", point, &BandRates::recall}, {"pick success", point, &BandRates::picks}})};
  }
  std::vector<Curve> recall, picks;
  for (const PointReport& point : points) {
    recall.push_back({point.name, &point, &BandRates::recall});
    picks.push_back({point.name, &point, &BandRates::picks});
  }
  return {CurvesOf({"recall", "Recall by visible fraction",
                    fmt::format("{} {}", kRecallCaption, kBandCaption), ""},
                   "recall", recall),
          CurvesOf({"pick-success", "Pick success by visible fraction",
                    fmt::format("{} {}", kPickCaption, kBandCaption), ""},
                   "pick success", picks)};
}

}  // namespace pickbed
