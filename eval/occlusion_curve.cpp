#include "eval/occlusion_curve.h"

#include <fmt/format.h>

#include <algorithm>

namespace pickbed {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

// The looks of one band, by scene.
struct BandLooks {
  int looks = 0;
  std::map<int, Cluster> recalled, picked;
  std::map<int, std::vector<double>> mssd, translation_m, rotation_rad;  // of the best pose
  double visible = 0;
};

const InstanceRecord* TargetOf(const PickRecord& look) {
  for (const InstanceRecord& instance : look.instances) {
    if (instance.instance == look.target) return &instance;
  }
  return nullptr;
}

void Count(bool hit, Cluster& cluster) {
  cluster.hits += hit;
  ++cluster.tries;
}

ShareOfLooks ShareOf(const std::map<int, Cluster>& by_scene) {
  std::vector<Cluster> clusters;
  for (const auto& [scene, cluster] : by_scene) clusters.push_back(cluster);
  return {SumOf(clusters).hits, ClusterInterval(clusters)};
}

// Hypotheses come with the highest score first; one further than this stands on no part.
constexpr double kStandsOnDiameters = 0.5;

const HypothesisScore* BestOnTarget(const PickRecord& look) {
  const HypothesisScore* best = nullptr;
  for (const HypothesisScore& h : look.hypotheses) {
    if (h.instance != look.target || h.mssd_diameters >= kStandsOnDiameters) continue;
    if (best == nullptr || h.score > best->score) best = &h;
  }
  return best;
}

ErrorMedian MedianOfScenes(const std::map<int, std::vector<double>>& by_scene) {
  ValueClusters clusters;
  for (const auto& [scene, values] : by_scene) clusters.push_back(values);
  return MedianWithin(clusters);
}

void CountErrors(int scene, const PickRecord& look, BandLooks& band, ErrorMedians& errors) {
  const HypothesisScore* best = BestOnTarget(look);
  if (best == nullptr) return;
  ++errors.looks;
  band.mssd[scene].push_back(best->mssd_diameters);
  band.translation_m[scene].push_back(best->translation_m);
  band.rotation_rad[scene].push_back(best->rotation_rad);
}

std::string Percent(int hits, const BandFigures& band) {
  return band.looks == 0 ? "-" : fmt::format("{:.1f} %", 100.0 * hits / band.looks);
}

std::string ShareText(const ShareOfLooks& share, const BandFigures& band) {
  if (band.looks == 0) return "-";
  return fmt::format("{} [{:.1f}, {:.1f}]", Percent(share.hits, band), 100 * share.ci95.low,
                     100 * share.ci95.high);
}

// A target that fills not all bands is given up; one that fills some has looks.
bool NoTargetFound(const std::vector<BandFigures>& bands) {
  return std::all_of(bands.begin(), bands.end(), [](const BandFigures& band) {
    return band.looks == 0 && band.trials_without > 0 && band.account.given_up == 0;
  });
}

std::string CsvLine(const std::string& point, const BandFigures& band) {
  std::string line =
      fmt::format("\"{}\",{},{},{},", point, band.band.least, band.band.most, band.looks);
  if (band.looks > 0) {
    line += fmt::format("{},{},{},{},{},{},{},{},{},", band.mean_visible, band.recalled.hits,
                        static_cast<double>(band.recalled.hits) / band.looks,
                        band.recalled.ci95.low, band.recalled.ci95.high, band.picked.hits,
                        static_cast<double>(band.picked.hits) / band.looks, band.picked.ci95.low,
                        band.picked.ci95.high);
  } else {
    line += ",,,,,,,,,";
  }
  line += fmt::format("{},{},{},{},", band.errors.looks, MedianCells(band.errors.mssd_diameters),
                      MedianCells(band.errors.translation_m.Times(1e3)),
                      MedianCells(band.errors.rotation_rad.Times(kDegrees)));
  const BlockerCounts& blockers = band.account.blockers;
  return line + fmt::format("{},{},{},{},{},{},{}\n", band.trials_without, band.account.given_up,
                            blockers.dropped, blockers.kept, blockers.refused, blockers.jumped,
                            blockers.useless);
}

}  // namespace

std::vector<BandFigures> FiguresByBand(std::span<const TrialResult> trials,
                                       const OcclusionSpec& spec) {
  std::vector<BandLooks> looks(spec.bands.size());
  std::vector<BandFigures> figures(spec.bands.size());
  for (const TrialResult& trial : trials) {
    for (const PickRecord& look : trial.picks) {
      if (look.target < 0 || look.band < 0 || look.band >= static_cast<int>(looks.size())) continue;
      const InstanceRecord* target = TargetOf(look);
      BandLooks& band = looks[look.band];
      ++band.looks;
      band.visible += target ? target->visible_fraction : 0;
      Count(target && target->recalled, band.recalled[trial.scene]);
      Count(look.loss == Loss::kNone, band.picked[trial.scene]);
      CountErrors(trial.scene, look, band, figures[look.band].errors);
      if (look.loss != Loss::kNone) {
        ++figures[look.band].losses[std::string(LossName(look.loss))];
      }
    }
    for (size_t i = 0; i < std::min(trial.bands.size(), figures.size()); ++i) {
      figures[i].trials_without += !trial.bands[i].filled;
      figures[i].account.given_up += trial.bands[i].given_up;
      figures[i].account.blockers.Add(trial.bands[i].blockers);
    }
  }
  for (size_t i = 0; i < figures.size(); ++i) {
    BandFigures& band = figures[i];
    band.band = spec.bands[i];
    band.looks = looks[i].looks;
    if (band.looks > 0) band.mean_visible = looks[i].visible / band.looks;
    band.recalled = ShareOf(looks[i].recalled);
    band.picked = ShareOf(looks[i].picked);
    band.errors.mssd_diameters = MedianOfScenes(looks[i].mssd);
    band.errors.translation_m = MedianOfScenes(looks[i].translation_m);
    band.errors.rotation_rad = MedianOfScenes(looks[i].rotation_rad);
  }
  return figures;
}

std::string CurveCsv(std::span<const NamedCurve> curves) {
  std::string csv =
      "point,visible_least,visible_most,looks,visible_mean,recalled,recall,recall_low,recall_high,"
      "picked,pick_rate,pick_low,pick_high,posed,mssd_diameters,mssd_low,mssd_high,"
      "translation_mm,translation_low,translation_high,rotation_deg,rotation_low,rotation_high,"
      "trials_without,targets_given_up,blockers,blockers_kept,blockers_refused,blockers_jumped,"
      "blockers_useless\n";
  for (const NamedCurve& curve : curves) {
    for (const BandFigures& band : curve.bands) csv += CsvLine(curve.point, band);
  }
  return csv;
}

std::string CurveTable(const std::vector<BandFigures>& bands) {
  std::string text =
      "Targets by visible fraction\n"
      "  band, %   looks  found                   picked                  median error of the best "
      "pose\n";
  for (const BandFigures& band : bands) {
    const std::string error =
        band.errors.looks == 0
            ? "-"
            : fmt::format("{} mm, {} deg", MedianText(band.errors.translation_m.Times(1e3), 1),
                          MedianText(band.errors.rotation_rad.Times(kDegrees), 1));
    text += fmt::format("  {:<10}{:<7}{:<24}{:<24}{}\n", band.band.name(), band.looks,
                        ShareText(band.recalled, band), ShareText(band.picked, band), error);
  }
  for (const BandFigures& band : bands) {
    if (band.trials_without == 0) continue;
    const BlockerCounts& b = band.account.blockers;
    text += fmt::format(
        "  {} %: trials without a scene: {}; targets given up: {}; of {} blockers {} hid too much, "
        "{} too little, {} disturbed the scene\n",
        band.band.name(), band.trials_without, band.account.given_up, b.dropped, b.jumped,
        b.useless, b.refused);
  }
  if (NoTargetFound(bands)) {
    text +=
        "  no scene came to rest with a part enough in view to be a target: look from higher up, "
        "drop fewer parts or end the bands lower\n";
  }
  return text;
}

}  // namespace pickbed
