#include "eval/summary/occlusion_curve.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/summary/run_columns.h"
#include "eval/trial/stage_oracle.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

// Sums over the attempts of one band, by scene number.
struct BandAttempts {
  int attempts = 0;
  std::map<int, Cluster> recalled, picked;
  std::map<int, std::vector<double>> mssd, translation_m, rotation_rad;  // errors of the best pose
  double visible = 0;
};

const InstanceRecord* TargetOf(const AttemptRecord& attempt) {
  for (const InstanceRecord& instance : attempt.instances) {
    if (instance.instance == attempt.target) return &instance;
  }
  return nullptr;
}

void Count(bool hit, Cluster& cluster) {
  cluster.hits += hit;
  ++cluster.samples;
}

ShareOfAttempts ShareOf(const std::map<int, Cluster>& by_scene) {
  std::vector<Cluster> clusters;
  for (const auto& [scene, cluster] : by_scene) clusters.push_back(cluster);
  return {SumOf(clusters).hits, ClusterInterval(clusters)};
}

const HypothesisRecord* BestOnTarget(const AttemptRecord& attempt) {
  const HypothesisRecord* best = nullptr;
  for (const HypothesisRecord& h : attempt.hypotheses) {
    if (h.instance != attempt.target || h.mssd_diameters() >= kMatchDiameters) continue;
    if (best == nullptr || h.score > best->score) best = &h;
  }
  return best;
}

ErrorMedian MedianOfScenes(const std::map<int, std::vector<double>>& by_scene) {
  ValueClusters clusters;
  for (const auto& [scene, values] : by_scene) clusters.push_back(values);
  return MedianWithin(clusters);
}

void CountErrors(int scene, const AttemptRecord& attempt, BandAttempts& band,
                 ErrorMedians& errors) {
  const HypothesisRecord* best = BestOnTarget(attempt);
  if (best == nullptr) return;
  ++errors.attempts;
  band.mssd[scene].push_back(best->mssd_diameters());
  band.translation_m[scene].push_back(best->translation_m());
  band.rotation_rad[scene].push_back(best->rotation_rad());
}

std::string ShareText(const ShareOfAttempts& share, const BandStatistics& band, bool few_bins) {
  const ReportRate rate{share.hits, band.attempts, share.ci95};
  return few_bins ? ShortRateText(rate) : RateText(rate);
}

std::string MedianOrShort(const ErrorMedian& median, bool few_bins) {
  if (few_bins && !median.ci95.is_known()) return fmt::format("{:.1f}", median.value);
  return MedianText(median, 1);
}

// True if no trial found a possible target. A target that fills only some bands is given up or has
// attempts.
bool NoTargetFound(const std::vector<BandStatistics>& bands) {
  return std::all_of(bands.begin(), bands.end(), [](const BandStatistics& band) {
    return band.attempts == 0 && band.trials_without > 0 && band.account.given_up == 0;
  });
}

std::string CsvLine(const std::string& configuration, const BandStatistics& band) {
  std::string line = fmt::format("{},{},{},{},", CsvCell(configuration), band.band.min,
                                 band.band.max, band.attempts);
  if (band.attempts > 0) {
    const auto share = [&](const ShareOfAttempts& of) {
      return fmt::format("{},{},{},", of.hits, static_cast<double>(of.hits) / band.attempts,
                         IntervalCells(of.ci95));
    };
    line += fmt::format("{},{}{}", band.mean_visible, share(band.recalled), share(band.picked));
  } else {
    line += ",,,,,,,,,";
  }
  line += fmt::format("{},{},{},{},", band.errors.attempts, MedianCells(band.errors.mssd_diameters),
                      MedianCells(band.errors.translation_m.Times(1e3)),
                      MedianCells(band.errors.rotation_rad.Times(kDegreesPerRadian)));
  const BlockerCounts& blockers = band.account.blockers;
  return line + fmt::format("{},{},{},{},{},{},{}\n", band.trials_without, band.account.given_up,
                            blockers.dropped, blockers.kept, blockers.refused, blockers.jumped,
                            blockers.useless);
}

}  // namespace

std::vector<BandStatistics> StatisticsByBand(std::span<const TrialResult> trials,
                                             const OcclusionSpec& spec) {
  std::vector<BandAttempts> attempts(spec.bands.size());
  std::vector<BandStatistics> statistics(spec.bands.size());
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.target < 0 || attempt.band < 0 ||
          attempt.band >= static_cast<int>(attempts.size()))
        continue;
      const InstanceRecord* target = TargetOf(attempt);
      BandAttempts& band = attempts[attempt.band];
      ++band.attempts;
      band.visible += target ? target->visible_fraction : 0;
      Count(target && target->recalled, band.recalled[trial.bin_index]);
      Count(attempt.failure == FailureReason::kNone, band.picked[trial.bin_index]);
      CountErrors(trial.bin_index, attempt, band, statistics[attempt.band].errors);
      if (attempt.failure != FailureReason::kNone) {
        ++statistics[attempt.band].failures[std::string(FailureName(attempt.failure))];
      }
    }
    for (size_t i = 0; i < std::min(trial.bands.size(), statistics.size()); ++i) {
      statistics[i].trials_without += !trial.bands[i].filled;
      statistics[i].account.given_up += trial.bands[i].given_up;
      statistics[i].account.blockers.Add(trial.bands[i].blockers);
    }
  }
  for (size_t i = 0; i < statistics.size(); ++i) {
    BandStatistics& band = statistics[i];
    band.band = spec.bands[i];
    band.attempts = attempts[i].attempts;
    if (band.attempts > 0) band.mean_visible = attempts[i].visible / band.attempts;
    band.recalled = ShareOf(attempts[i].recalled);
    band.picked = ShareOf(attempts[i].picked);
    band.errors.mssd_diameters = MedianOfScenes(attempts[i].mssd);
    band.errors.translation_m = MedianOfScenes(attempts[i].translation_m);
    band.errors.rotation_rad = MedianOfScenes(attempts[i].rotation_rad);
  }
  return statistics;
}

std::string CurveCsv(std::span<const NamedCurve> curves) {
  std::string csv = HeaderLine(CurveColumns());
  for (const NamedCurve& curve : curves) {
    for (const BandStatistics& band : curve.bands) csv += CsvLine(curve.configuration, band);
  }
  return csv;
}

std::string CurveTable(const std::vector<BandStatistics>& bands, bool few_bins) {
  std::string text =
      "Targets by visible fraction\n  band, %   att.   found                   picked              "
      "    median error of the best pose\n";
  for (const BandStatistics& band : bands) {
    const std::string error =
        band.errors.attempts == 0
            ? "-"
            : fmt::format(
                  "{} mm, {} deg", MedianOrShort(band.errors.translation_m.Times(1e3), few_bins),
                  MedianOrShort(band.errors.rotation_rad.Times(kDegreesPerRadian), few_bins));
    text += fmt::format("  {:<10}{:<7}{:<24}{:<24}{}\n", band.band.name(), band.attempts,
                        ShareText(band.recalled, band, few_bins),
                        ShareText(band.picked, band, few_bins), error);
  }
  for (const BandStatistics& band : bands) {
    if (band.trials_without == 0) continue;
    const BlockerCounts& b = band.account.blockers;
    text += fmt::format(
        "  {} %: trials without a scene: {}; rejected targets: {}; of {} blockers {} hid too much, "
        "{} too little, {} moved the other instances\n",
        band.band.name(), band.trials_without, band.account.given_up, b.dropped, b.jumped,
        b.useless, b.refused);
  }
  if (NoTargetFound(bands)) {
    text +=
        "  no settled scene had an instance with a visible fraction that makes it a target: raise "
        "the camera, drop fewer objects or lower the bands\n";
  }
  return text;
}

}  // namespace pickbed::eval
