#include "eval/tolerance/report.h"

#include <fmt/format.h>

#include "eval/tolerance/draw.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

std::string Signed(const AucDifference& d) {
  return fmt::format("{:+.3f} [{:+.3f}, {:+.3f}]", d.difference, d.interval.low, d.interval.high);
}

}  // namespace

std::vector<std::vector<std::string>> PredictorCells(const std::vector<Predictor>& predictors) {
  std::vector<std::vector<std::string>> rows{{"score", "AUC"}};
  if (!predictors.empty()) rows.front().push_back("less " + predictors.front().name);
  for (const Predictor& p : predictors) {
    const bool first = &p == &predictors.front();
    if (p.auc.is_known()) {
      rows.push_back({p.name, AucText(p.auc), first ? "" : Signed(p.to_first)});
    } else {
      rows.push_back({p.name, "all picks had one outcome", ""});
    }
  }
  return rows;
}

std::string PredictorText(const std::vector<Predictor>& predictors, const std::string& picks) {
  if (predictors.empty()) return "";
  const AucResult& first = predictors.front().auc;
  if (!first.is_known()) {
    return fmt::format("  all {} picks {} ({}): no score can be judged by them\n",
                       first.successes + first.failures,
                       first.failures == 0 ? "succeeded" : "failed", picks);
  }
  std::string text = fmt::format(
      "How well a score tells picks that succeed from those that fail ({}: {} succeeded, "
      "{} failed)\n  {:<14}{:<24}less {}\n",
      picks, first.successes, first.failures, "", "AUC [95 %]", predictors.front().name);
  for (const Predictor& p : predictors) {
    text += fmt::format("  {:<14}{:<24}{}\n", p.name, AucText(p.auc),
                        &p == &predictors.front() ? "" : Signed(p.to_first));
  }
  return text;
}

std::string ToleranceText(const ToleranceFigures& figures) {
  std::string text = fmt::format(
      "{} with {}: {} {} of {} grasps succeed where the pose is true\n"
      "Errors that keep picks going\n",
      figures.object, figures.gripper, PercentText(figures.at_truth.share()),
      IntervalText(figures.at_truth.band()), figures.at_truth.tries);
  for (const AxisCurve& curve : figures.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    text += fmt::format("  {:<5}{:<32}{}\n", axis.name, curve.help,
                        RegionText(curve.region, axis.unit));
  }
  text += PredictorText(figures.predictors, "held-out errors");
  text += fmt::format("Brier score of the probability: {:.3f}\n", figures.brier);
  return text;
}

std::string AxesCsv(const ToleranceFigures& figures) {
  std::string csv = "axis,unit,error,successes,samples,share,low,high,kept_from,kept_to\n";
  for (const AxisCurve& curve : figures.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    for (const LevelShare& level : curve.levels) {
      const Interval band = level.band();
      csv += fmt::format("{},{},{:g},{},{},{:.4f},{:.4f},{:.4f},{:.3f},{:.3f}\n", axis.name,
                         axis.unit, level.offset, level.successes, level.tries, level.share(),
                         band.low, band.high, curve.region.low, curve.region.high);
    }
  }
  return csv;
}

std::string PairsCsv(const ToleranceFigures& figures) {
  std::string csv = "axis_a,axis_b,error_a,error_b,successes,samples,share,low,high\n";
  for (const PairMap& map : figures.pairs) {
    for (size_t i = 0; i < map.cells.size(); ++i) {
      const LevelShare& cell = map.cells[i];
      const Interval band = cell.band();
      csv += fmt::format("{},{},{:g},{:g},{},{},{:.4f},{:.4f},{:.4f}\n",
                         ErrorAxisTable()[map.axis[0]].name, ErrorAxisTable()[map.axis[1]].name,
                         map.offsets_a[i % map.offsets_a.size()],
                         map.offsets_b[i / map.offsets_a.size()], cell.successes, cell.tries,
                         cell.share(), band.low, band.high);
    }
  }
  return csv;
}

std::string PredictorsCsv(const std::vector<Predictor>& predictors) {
  std::string csv = "score,auc,low,high,less_first,less_low,less_high,successes,failures\n";
  for (const Predictor& p : predictors) {
    if (!p.auc.is_known()) {
      csv += fmt::format("{},,,,,,,{},{}\n", p.name, p.auc.successes, p.auc.failures);
      continue;
    }
    csv += fmt::format("{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{}\n", p.name, p.auc.auc,
                       p.auc.interval.low, p.auc.interval.high, p.to_first.difference,
                       p.to_first.interval.low, p.to_first.interval.high, p.auc.successes,
                       p.auc.failures);
  }
  return csv;
}

void WriteToleranceFiles(const ToleranceStudy& study, const ToleranceFigures& figures,
                         const std::filesystem::path& folder) {
  ToleranceOptions options = study.options;
  WriteFileAtomically(folder / "tolerance.yaml",
                      WriteSettings([&](SettingsVisitor& v) { options.Visit(v); }));
  WriteFileAtomically(folder / "axes.csv", AxesCsv(figures));
  WriteFileAtomically(folder / "predictors.csv", PredictorsCsv(figures.predictors));
  WriteToleranceModel(folder / "model.yaml", figures.model);
  WritePng(folder / "map.png", DrawToleranceSheet(study, figures));
  if (figures.pairs.empty()) return;
  WriteFileAtomically(folder / "pairs.csv", PairsCsv(figures));
  WritePng(folder / "pairs.png", DrawPairSheet(figures));
}

}  // namespace pickbed::eval
