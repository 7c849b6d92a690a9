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
  std::vector<std::string> bands;
  for (const BandRates& band : curves.front().point->bands) bands.push_back(band.name);
  std::vector<RateCurve> rates;
  for (const Curve& curve : curves) {
    RateCurve& of_series = rates.emplace_back(RateCurve{curve.series, {}});
    for (const BandRates& band : curve.point->bands) of_series.rates.push_back(band.*curve.rate);
  }
  return RateCurves(std::move(chart), "visible fraction of the part", y_title, bands, rates);
}

constexpr const char* kRecallCaption =
    "Recall: share of the parts in view of which a pose was reported that is right (MSSD below a "
    "tenth of the diameter).";
constexpr const char* kPickCaption =
    "Pick success: share of the executed grasps that brought their part, by how much of it was in "
    "view.";
constexpr const char* kTargetCaption =
    "Share of the looks about a target that brought it; one that found no grasp did not.";
constexpr const char* kBandCaption = "Shaded: 95 % intervals, with scenes as units.";

std::vector<Curve> OfEach(std::span<const PointReport> points, ReportRate BandRates::*rate) {
  std::vector<Curve> curves;
  for (const PointReport& point : points) curves.push_back({point.name, &point, rate});
  return curves;
}

bool HasTargets(std::span<const PointReport> points) {
  for (const PointReport& point : points) {
    for (const BandRates& band : point.bands) {
      if (band.targets.tries > 0) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<ReportChart> VisibilityCharts(std::span<const PointReport> points) {
  std::vector<ReportChart> charts;
  if (points.size() == 1) {
    const PointReport* point = points.data();
    charts.push_back(CurvesOf(
        {"visibility", "Recall and pick success by visible fraction",
         fmt::format("{} {} {}", kRecallCaption, kPickCaption, kBandCaption), ""},
        "share",
        {{"recall", point, &BandRates::recall}, {"pick success", point, &BandRates::picks}}));
  } else {
    charts.push_back(CurvesOf({"recall", "Recall by visible fraction",
                               fmt::format("{} {}", kRecallCaption, kBandCaption), ""},
                              "recall", OfEach(points, &BandRates::recall)));
    charts.push_back(CurvesOf({"pick-success", "Pick success by visible fraction",
                               fmt::format("{} {}", kPickCaption, kBandCaption), ""},
                              "pick success", OfEach(points, &BandRates::picks)));
  }
  if (HasTargets(points)) {
    charts.push_back(CurvesOf({"target-picked", "Targets picked by visible fraction",
                               fmt::format("{} {}", kTargetCaption, kBandCaption), ""},
                              "targets picked", OfEach(points, &BandRates::targets)));
  }
  return charts;
}

}  // namespace pickbed
