#include "eval/calibrate/report.h"

#include <fmt/format.h>

#include "eval/page/vega.h"

namespace pickbed::eval {
namespace {

std::string ValueText(const ClusterValue& value, bool is_signed = false) {
  const auto number = [&](double x) {
    return is_signed ? fmt::format("{:+.3f}", x) : fmt::format("{:.3f}", x);
  };
  if (!value.ci95.is_known()) return fmt::format("{} ({})", number(value.value), kTooFewBins);
  return fmt::format("{} [{}, {}]", number(value.value), number(value.ci95.low),
                     number(value.ci95.high));
}

// Header, then calibration error and Brier score.
TableCells QualityTable(const CalibrationFit& fit) {
  TableCells table{{"", "before", "after, cross-validated", "change"}};
  const auto add = [&](const char* name, const FittedCurve& curve, const char* measure,
                       ClusterValue ForecastQuality::*value) {
    table.push_back(
        {fmt::format("{}: {}", name, measure),
         curve.quality_before ? ValueText((*curve.quality_before).*value) : "no probability",
         ValueText(curve.quality_after.*value),
         curve.change ? ValueText((*curve.change).*value, true) : "-"});
  };
  const auto add_both = [&](const char* name, const FittedCurve& curve) {
    add(name, curve, "calibration error", &ForecastQuality::calibration_error);
    add(name, curve, "Brier score", &ForecastQuality::brier);
  };
  add_both("P(pose right)", fit.pose_right);
  if (fit.pick_succeeds) add_both("P(pick succeeds)", *fit.pick_succeeds);
  return table;
}

CalibrationCurve ReliabilityCurveOf(const std::string& series, const ForecastClusters& forecasts) {
  CalibrationCurve curve{series, {}};
  for (const ReliabilityPoint& point : ReliabilityOf(forecasts)) {
    curve.points.push_back({point.mean_probability, point.rate});
  }
  return curve;
}

ReportChart ReliabilityDiagram(const std::string& id, const std::string& title,
                               const std::string& rate, const FittedCurve& fitted) {
  std::vector<CalibrationCurve> curves;
  if (!fitted.before.empty()) curves.push_back(ReliabilityCurveOf("before", fitted.before));
  curves.push_back(ReliabilityCurveOf("after", fitted.after));
  ReportChart chart{
      id, title,
      "On the dotted line, the rate equals the probability. Bars: 95 % intervals over "
      "bins. After: converted by curves that were fitted to other bins.",
      ""};
  chart.table = {{"scores", "mean probability", rate + " [95 %]", "samples"}};
  return CalibrationCurves(std::move(chart), "probability", rate, curves);
}

ReportChart FittedCurves(const CalibrationFit& fit) {
  const auto curve_of = [](const std::string& series, const ScoreCurve& fitted) {
    ValueCurve curve{series, {}};
    for (const ScoreKnot& knot : fitted.knots) {
      curve.points.push_back({knot.score, knot.probability, knot.probability, knot.probability});
    }
    return curve;
  };
  std::vector<ValueCurve> curves{curve_of("P(pose right)", fit.pose_right.curve)};
  if (fit.pick_succeeds) {
    curves.push_back(curve_of("P(pick succeeds)", fit.pick_succeeds->curve));
  }
  return ValueCurves({"curves", "Probability by score",
                      "Isotonic regression on all samples, linear between its steps.", ""},
                     "score of the estimator", "probability", curves, /*y_max=*/1);
}

std::string SamplesText(const CalibrationFit& fit) {
  int picks = 0;
  for (const auto& cluster : fit.samples.picks) picks += static_cast<int>(cluster.size());
  return fmt::format(
      "estimator {}: {} poses in {} bins, {} right; {} picks{}", fit.samples.estimator.name,
      fit.pose_right.samples, fit.pose_right.after.size(), fit.pose_right.hits, picks,
      fit.pick_succeeds ? fmt::format(", {} successful", fit.pick_succeeds->hits) : "");
}

// Why there is no curve for picks, as a sentence; empty if there is one.
std::string NoPicksText(const CalibrationFit& fit) {
  return fit.no_picks.empty()
             ? ""
             : fmt::format("no curve for P(pick succeeds): the run {}", fit.no_picks);
}

}  // namespace

std::string CalibrationText(const CalibrationFit& fit) {
  std::string text = SamplesText(fit) + "\n";
  for (const std::vector<std::string>& line : QualityTable(fit)) {
    text += fmt::format("{:<38}{:<26}{:<26}{}\n", line[0], line[1], line[2], line[3]);
  }
  const std::string no_picks = NoPicksText(fit);
  if (!no_picks.empty()) text += no_picks + "\n";
  const std::string few = FewBinsText(static_cast<int>(fit.pose_right.after.size()));
  if (!few.empty()) text += few + "\n";
  return text;
}

HtmlPage CalibrationReport(const CalibrationFit& fit) {
  HtmlPage page("Calibration of " + fit.samples.estimator.name);
  page.Paragraph(fmt::format("Run {}. {}.", fit.samples.run, SamplesText(fit)));
  page.Paragraph(
      "The calibration error is the mean difference between probability and rate over ten ranges. "
      "The Brier score is the mean squared difference between probability and outcome. Brackets "
      "are 95 % intervals over bins.");
  page.Table(QualityTable(fit));
  page.Paragraph(NoPicksText(fit));
  page.Heading("Curves");
  std::vector<ReportChart> charts{
      FittedCurves(fit), ReliabilityDiagram("reliability-poses", "Poses", "right", fit.pose_right)};
  if (fit.pick_succeeds) {
    charts.push_back(
        ReliabilityDiagram("reliability-picks", "Picks", "successful", *fit.pick_succeeds));
  }
  page.Charts(charts);
  return page;
}

}  // namespace pickbed::eval
