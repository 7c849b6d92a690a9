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
  if (!predictors.empty()) rows.front().push_back("minus " + predictors.front().name);
  for (const Predictor& p : predictors) {
    const bool first = &p == &predictors.front();
    if (p.auc.is_known()) {
      rows.push_back({p.name, AucText(p.auc), first ? "" : Signed(p.to_first)});
    } else {
      rows.push_back({p.name, "all picks had the same outcome", ""});
    }
  }
  return rows;
}

std::string PredictorText(const std::vector<Predictor>& predictors, const std::string& picks) {
  if (predictors.empty()) return "";
  const AucResult& first = predictors.front().auc;
  if (!first.is_known()) {
    return fmt::format("  all {} picks {} ({}): scores cannot be compared\n",
                       first.successes + first.failures,
                       first.failures == 0 ? "succeeded" : "failed", picks);
  }
  std::string text = fmt::format(
      "How well each score separates successful from failed picks ({}: {} succeeded, {} failed)\n  "
      "{:<14}{:<24}minus {}\n",
      picks, first.successes, first.failures, "", "AUC [95 %]", predictors.front().name);
  for (const Predictor& p : predictors) {
    text += fmt::format("  {:<14}{:<24}{}\n", p.name, AucText(p.auc),
                        &p == &predictors.front() ? "" : Signed(p.to_first));
  }
  return text;
}

std::string ToleranceText(const ToleranceStatistics& statistics) {
  std::string text = fmt::format(
      "{} with {}: {} {} of {} grasps succeed at the true pose\nPose errors that still allow a "
      "pick\n",
      statistics.object, statistics.gripper, PercentText(statistics.at_truth.share()),
      IntervalText(statistics.at_truth.band()), statistics.at_truth.samples);
  for (const AxisCurve& curve : statistics.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    text += fmt::format("  {:<5}{:<32}{}\n", axis.name, curve.help,
                        RegionText(curve.region, axis.unit));
  }
  text += PredictorText(statistics.predictors, "held-out errors");
  text += fmt::format("Brier score of the probability: {:.3f}\n", statistics.brier);
  return text;
}

std::string AxesCsv(const ToleranceStatistics& statistics) {
  std::string csv = "axis,unit,error,successes,samples,share,low,high,kept_from,kept_to\n";
  for (const AxisCurve& curve : statistics.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    for (const LevelShare& level : curve.levels) {
      const Interval band = level.band();
      csv += fmt::format("{},{},{:g},{},{},{:.4f},{:.4f},{:.4f},{:.3f},{:.3f}\n", axis.name,
                         axis.unit, level.offset, level.successes, level.samples, level.share(),
                         band.low, band.high, curve.region.low, curve.region.high);
    }
  }
  return csv;
}

std::string PairsCsv(const ToleranceStatistics& statistics) {
  std::string csv = "axis_a,axis_b,error_a,error_b,successes,samples,share,low,high\n";
  for (const PairMap& map : statistics.pairs) {
    for (size_t i = 0; i < map.cells.size(); ++i) {
      const LevelShare& cell = map.cells[i];
      const Interval band = cell.band();
      csv += fmt::format("{},{},{:g},{:g},{},{},{:.4f},{:.4f},{:.4f}\n",
                         ErrorAxisTable()[map.axis[0]].name, ErrorAxisTable()[map.axis[1]].name,
                         map.offsets_a[i % map.offsets_a.size()],
                         map.offsets_b[i / map.offsets_a.size()], cell.successes, cell.samples,
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

void WriteToleranceFiles(const ToleranceStudy& study, const ToleranceStatistics& statistics,
                         const std::filesystem::path& folder) {
  ToleranceOptions options = study.options;
  WriteFileAtomically(folder / "tolerance.yaml",
                      WriteSettings([&](SettingsVisitor& v) { options.Visit(v); }));
  WriteFileAtomically(folder / "axes.csv", AxesCsv(statistics));
  WriteFileAtomically(folder / "predictors.csv", PredictorsCsv(statistics.predictors));
  WriteToleranceModel(folder / "model.yaml", statistics.model);
  WritePng(folder / "map.png", DrawToleranceSheet(study, statistics));
  if (statistics.pairs.empty()) return;
  WriteFileAtomically(folder / "pairs.csv", PairsCsv(statistics));
  WritePng(folder / "pairs.png", DrawPairSheet(statistics));
}

}  // namespace pickbed::eval
