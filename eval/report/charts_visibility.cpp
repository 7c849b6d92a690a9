#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "eval/report/charts_impl.h"

namespace pickbed {
namespace {

struct Curve {
  std::string series;
  const PointReport* point;
  ReportRate BandRates::*rate;
};

// Each once, from the least visible on: settings that are seen together may have bands of their
// own.
std::vector<VisibleBand> BandsOfAll(const std::vector<Curve>& curves) {
  std::vector<VisibleBand> bands;
  for (const Curve& curve : curves) {
    for (const BandRates& of_band : curve.point->bands) bands.push_back(of_band.band);
  }
  const auto ends = [](const VisibleBand& band) { return std::pair(band.least, band.most); };
  std::sort(bands.begin(), bands.end(),
            [&](const VisibleBand& a, const VisibleBand& b) { return ends(a) < ends(b); });
  bands.erase(std::unique(bands.begin(), bands.end()), bands.end());
  return bands;
}

ReportChart CurvesOf(ReportChart chart, const std::string& y_title,
                     const std::vector<Curve>& curves) {
  const std::vector<VisibleBand> bands = BandsOfAll(curves);
  std::vector<std::string> names;
  for (const VisibleBand& band : bands) names.push_back(band.name());
  std::vector<RateCurve> rates;
  for (const Curve& curve : curves) {
    RateCurve& of_series = rates.emplace_back(RateCurve{curve.series, {}});
    of_series.rates.resize(bands.size());
    for (const BandRates& of_band : curve.point->bands) {
      const auto place = std::find(bands.begin(), bands.end(), of_band.band) - bands.begin();
      of_series.rates[place] = of_band.*curve.rate;
    }
  }
  return RateCurves(std::move(chart), "visible fraction of the part, %", y_title, names, rates);
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
