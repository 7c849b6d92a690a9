#include "eval/tolerance/report.h"

#include <fmt/format.h>

#include "eval/tolerance/draw.h"
#include "eval/tolerance/maps.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

constexpr int kDecimals = 4;  // of shares in CSV files

std::string Signed(const AucDifference& d) {
  if (!d.interval.is_known()) return fmt::format("{:+.3f} ({})", d.difference, kTooFewBins);
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
      BandText(statistics.at_truth), statistics.at_truth.samples);
  for (const AxisCurve& curve : statistics.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    text += fmt::format("  {:<5}{:<32}{}\n", axis.name, curve.help,
                        RegionText(curve.region, axis.unit));
  }
  text += PredictorText(statistics.predictors, "held-out errors");
  text += fmt::format("Brier score of the probability: {:.3f}\n", statistics.brier);
  return text;
}

ResultColumns AxesColumns() {
  return {
      {"axis", "axis of the pose error: x y z rx ry rz of the object, gx ... grz of the gripper"},
      {"unit", "unit of error, kept_from and kept_to: mm or deg"},
      {"error", "pose error along or about the axis", "unit"},
      {"successes", "number of executed grasps that succeeded"},
      {"samples", "number of executed grasps"},
      {"share", "successes / samples", "0..1"},
      {"low", "lower end of the 95 % interval of share", "0..1"},
      {"high", "upper end of the 95 % interval of share", "0..1"},
      {"kept_from", "lower end of the tolerated region of the axis", "unit"},
      {"kept_to", "upper end of the tolerated region of the axis", "unit"},
  };
}

ResultColumns PairsColumns() {
  return {
      {"axis_a", fmt::format("first axis of the pair, see {}", kAxesFile)},
      {"axis_b", "second axis of the pair"},
      {"error_a", "pose error along or about the first axis", "mm or deg"},
      {"error_b", "pose error along or about the second axis", "mm or deg"},
      {"successes", "number of executed grasps that succeeded"},
      {"samples", "number of executed grasps"},
      {"share", "successes / samples", "0..1"},
      {"low", "lower end of the 95 % interval of share", "0..1"},
      {"high", "upper end of the 95 % interval of share", "0..1"},
  };
}

ResultColumns PredictorsColumns() {
  return {
      {"score", "name of the score that predicts success"},
      {"auc", "probability that the score ranks a successful pick above a failed one", "0..1"},
      {"low", "lower end of the 95 % interval of auc", "0..1"},
      {"high", "upper end of the 95 % interval of auc", "0..1"},
      {"less_first", "auc minus the auc of the first score"},
      {"less_low", "lower end of the 95 % interval of less_first"},
      {"less_high", "upper end of the 95 % interval of less_first"},
      {"successes", "number of successful picks"},
      {"failures", "number of failed picks"},
  };
}

std::string AxesCsv(const ToleranceStatistics& statistics) {
  std::string csv = HeaderLine(AxesColumns());
  for (const AxisCurve& curve : statistics.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    for (const LevelShare& level : curve.levels) {
      csv +=
          fmt::format("{},{},{:g},{},{},{:.4f},{},{:.3f},{:.3f}\n", axis.name, axis.unit,
                      level.offset, level.successes, level.samples, level.share(),
                      IntervalCells(level.band(), kDecimals), curve.region.low, curve.region.high);
    }
  }
  return csv;
}

std::string PairsCsv(const ToleranceStatistics& statistics) {
  std::string csv = HeaderLine(PairsColumns());
  for (const PairMap& map : statistics.pairs) {
    for (size_t i = 0; i < map.cells.size(); ++i) {
      const LevelShare& cell = map.cells[i];
      csv +=
          fmt::format("{},{},{:g},{:g},{},{},{:.4f},{}\n", ErrorAxisTable()[map.axis[0]].name,
                      ErrorAxisTable()[map.axis[1]].name, map.offsets_a[i % map.offsets_a.size()],
                      map.offsets_b[i / map.offsets_a.size()], cell.successes, cell.samples,
                      cell.share(), IntervalCells(cell.band(), kDecimals));
    }
  }
  return csv;
}

std::string PredictorsCsv(const std::vector<Predictor>& predictors) {
  std::string csv = HeaderLine(PredictorsColumns());
  for (const Predictor& p : predictors) {
    if (!p.auc.is_known()) {
      csv += fmt::format("{},,,,,,,{},{}\n", p.name, p.auc.successes, p.auc.failures);
      continue;
    }
    csv +=
        fmt::format("{},{:.4f},{},{:.4f},{},{},{}\n", p.name, p.auc.auc,
                    IntervalCells(p.auc.interval, kDecimals), p.to_first.difference,
                    IntervalCells(p.to_first.interval, kDecimals), p.auc.successes, p.auc.failures);
  }
  return csv;
}

void WriteToleranceFiles(const ToleranceStudy& study, const ToleranceStatistics& statistics,
                         const std::filesystem::path& folder) {
  ToleranceOptions options = study.options;
  WriteFileAtomically(folder / kToleranceFile,
                      WriteSettings([&](SettingsVisitor& v) { options.Visit(v); }));
  WriteFileAtomically(folder / kAxesFile, AxesCsv(statistics));
  WriteFileAtomically(folder / kPredictorsFile, PredictorsCsv(statistics.predictors));
  WriteToleranceModel(folder / kToleranceModelFile, statistics.model);
  WritePng(folder / "map.png", DrawToleranceSheet(study, statistics));
  if (statistics.pairs.empty()) return;
  WriteFileAtomically(folder / kPairsFile, PairsCsv(statistics));
  WritePng(folder / "pairs.png", DrawPairSheet(statistics));
}

}  // namespace pickbed::eval
