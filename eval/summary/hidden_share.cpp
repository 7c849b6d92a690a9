#include "eval/summary/hidden_share.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/draw/canvas.h"
#include "eval/draw/plot.h"
#include "eval/metrics/interval_json.h"
#include "eval/trial/counts_by_bin.h"

namespace pickbed::eval {
namespace {

constexpr double kBandWidth = 0.1;

constexpr PublishedCurve kTargoCurves[] = {
    {"TARGO-Net", "targo_net", {.870, .811, .837, .806, .819, .806, .808, .797, .798}},
    {"GIGA-HR", "giga_hr", {.813, .735, .728, .696, .695, .657, .591, .611, .576}},
    {"GIGA", "giga", {.798, .717, .691, .669, .683, .650, .627, .632, .600}},
    {"VGN", "vgn", {.727, .637, .622, .606, .588, .584, .572, .532, .502}},
    {"VN-EdgeGraspNet", "vn_edgegraspnet", {.639, .594, .602, .598, .584, .573, .508, .445, .388}},
    {"EdgeGraspNet", "edgegraspnet", {.603, .580, .584, .585, .551, .531, .434, .377, .272}},
};

// Grays for the published curves, then colors for the configurations. The last color repeats.
constexpr Rgb8 kPublishedColors[] = {{60, 60, 60},    {110, 90, 60},   {90, 110, 130},
                                     {150, 120, 150}, {130, 150, 110}, {170, 160, 140}};
constexpr Rgb8 kOwnColors[] = {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}};

// The visible fraction of a band's target is in [visible_min, visible_max), as in OcclusionSpec.
double VisibleMin(const HiddenBand& band) { return 1 - band.hidden_max; }
double VisibleMax(const HiddenBand& band) { return 1 - band.hidden_min; }

const InstanceRecord* TargetIn(const AttemptRecord& attempt) {
  const auto found =
      std::find_if(attempt.instances.begin(), attempt.instances.end(),
                   [&](const InstanceRecord& record) { return record.instance == attempt.target; });
  return attempt.target < 0 || found == attempt.instances.end() ? nullptr : &*found;
}

double MeanHidden(std::span<const TrialResult> trials, const HiddenBand& band) {
  double sum = 0;
  int count = 0;
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      const InstanceRecord* target = TargetIn(attempt);
      if (target == nullptr || target->visible_fraction < VisibleMin(band)) continue;
      if (target->visible_fraction >= VisibleMax(band) && VisibleMax(band) < 1) continue;
      sum += 1 - target->visible_fraction;
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

std::string RateCells(const ReportRate& rate) {
  if (rate.samples == 0) return ",,,";
  return fmt::format("{},{},{}", rate.hits, rate.rate(), IntervalCells(rate.ci95));
}

// Center of a band on the axis of hidden percent.
double CenterOf(int band) { return 100 * kBandWidth * (band + 0.5); }

}  // namespace

std::span<const PublishedCurve> TargoCurves() { return kTargoCurves; }

std::vector<std::string> HiddenShareNote() {
  return {
      "Published: success of grasps on the target in the TARGO benchmark, about 1000 scenes a "
      "band.",
      "Objects: there, many unseen household objects; here, the objects of the scenario.",
      "Gripper: there, a parallel jaw; here, the gripper of the scenario.",
      "Target: there, it is given to the method; here, the estimator must find it.",
      "Blockers: there, neighbors are removed in pairs; here, blockers are dropped on it."};
}

std::vector<HiddenBand> StatisticsByHiddenShare(std::span<const TrialResult> trials) {
  std::vector<TrialResult> with_target;
  for (const TrialResult& trial : trials) {
    with_target.push_back(trial);
    std::erase_if(with_target.back().attempts,
                  [](const AttemptRecord& attempt) { return attempt.target < 0; });
  }
  const std::vector<int> scenes = ScenesOf(with_target);
  std::vector<HiddenBand> bands;
  for (int i = 0; i < kHiddenBands; ++i) {
    HiddenBand& band = bands.emplace_back();
    band.hidden_min = i / 10.0;
    band.hidden_max = (i + 1) / 10.0;
    band.mean_hidden = MeanHidden(with_target, band);
    const auto rate = [&](const TrialCount& count) {
      return ClusterRate(CountByScene(with_target, scenes, count));
    };
    band.recalled = rate(InstancesRecalled(VisibleMin(band), VisibleMax(band)));
    band.picked = rate(TargetsPicked(VisibleMin(band), VisibleMax(band)));
  }
  return bands;
}

ResultColumns HiddenShareColumns() {
  constexpr char kShare[] = "0..1";
  ResultColumns columns{
      {"configuration", "name of the configuration; empty for a run"},
      {"hidden_min", "lower limit of the target's hidden share", kShare},
      {"hidden_max", "upper limit of the target's hidden share", kShare},
      {"attempts", "number of attempts with a target in this band"},
      {"hidden_mean", "mean hidden share of the target", kShare},
      {"recalled", "number of attempts with a correct pose of the target"},
      {"recall", "recalled / attempts", kShare},
      {"recall_low", "lower end of the 95 % interval of recall", kShare},
      {"recall_high", "upper end of the 95 % interval of recall", kShare},
      {"picked", "number of picks of the target"},
      {"pick_rate", "picked / attempts; an attempt without a grasp picked nothing", kShare},
      {"pick_low", "lower end of the 95 % interval of pick_rate", kShare},
      {"pick_high", "upper end of the 95 % interval of pick_rate", kShare},
  };
  for (const PublishedCurve& curve : kTargoCurves) {
    columns.push_back({curve.column,
                       fmt::format("published success of {} in the TARGO benchmark", curve.method),
                       kShare});
  }
  return columns;
}

std::string HiddenShareCsv(std::span<const NamedHiddenCurve> curves) {
  std::string csv = HeaderLine(HiddenShareColumns());
  for (const NamedHiddenCurve& curve : curves) {
    for (size_t i = 0; i < curve.bands.size(); ++i) {
      const HiddenBand& band = curve.bands[i];
      const int attempts = band.picked.samples;
      csv += fmt::format("{},{},{},{},{},{},{}", CsvCell(curve.configuration), band.hidden_min,
                         band.hidden_max, attempts,
                         attempts > 0 ? fmt::format("{}", band.mean_hidden) : "",
                         RateCells(band.recalled), RateCells(band.picked));
      for (const PublishedCurve& published : kTargoCurves) {
        csv += fmt::format(",{}", published.success[i]);
      }
      csv += "\n";
    }
  }
  return csv;
}

Image<Rgb8> DrawHiddenShare(std::span<const NamedHiddenCurve> curves) {
  constexpr int kWidth_px = 900, kHeight_px = 480, kLine_px = 20, kMargin_px = 10;
  constexpr Rgb8 kPaper{255, 255, 255}, kInk{20, 20, 20};
  Chart chart;
  chart.x_label = "hidden share of the target, %";
  chart.percent = true;
  std::vector<LegendEntry> legend;
  for (size_t i = 0; i < std::size(kTargoCurves); ++i) {
    ChartSeries& series = chart.series.emplace_back();
    series.color = kPublishedColors[i];
    legend.push_back({series.color, kTargoCurves[i].method});
    for (int band = 0; band < kHiddenBands; ++band) {
      series.points.emplace_back(CenterOf(band), kTargoCurves[i].success[band]);
    }
  }
  for (size_t i = 0; i < curves.size(); ++i) {
    ChartSeries line;
    line.color = kOwnColors[std::min(i, std::size(kOwnColors) - 1)];
    for (size_t band = 0; band < curves[i].bands.size(); ++band) {
      const HiddenBand& of_band = curves[i].bands[band];
      if (of_band.picked.samples == 0) continue;
      line.points.emplace_back(100 * of_band.mean_hidden, of_band.picked.rate());
      line.band.push_back(of_band.picked.ci95);
    }
    if (line.points.empty()) continue;
    const std::string& name = curves[i].configuration;
    legend.push_back({line.color, name.empty() ? "this run" : name});
    ChartSeries dots = line;
    dots.dots = true;
    dots.band.clear();
    chart.series.push_back(std::move(line));
    chart.series.push_back(std::move(dots));
  }
  Canvas plot(kWidth_px, kHeight_px + kLine_px, kPaper);
  plot.Text("Targets picked by hidden share; shaded: 95 % intervals", kMargin_px, kLine_px - 4,
            kInk);
  plot.Paste(DrawChart(chart, kWidth_px, kHeight_px, 1), 0, kLine_px);
  const Image<Rgb8> picture = WithLegend(plot.Take(), legend);
  const std::vector<std::string> note = HiddenShareNote();
  Canvas canvas(picture.width(), picture.height() + kLine_px * (static_cast<int>(note.size()) + 1),
                kPaper);
  canvas.Paste(picture, 0, 0);
  for (size_t i = 0; i < note.size(); ++i) {
    const int y = picture.height() + kLine_px * (static_cast<int>(i) + 1);
    canvas.TextWithin(picture.width() - 2 * kMargin_px, note[i], kMargin_px, y, kInk);
  }
  return canvas.Take();
}

}  // namespace pickbed::eval
