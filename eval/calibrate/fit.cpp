#include "eval/calibrate/fit.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/stats/isotonic.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

Cluster CountsOf(const OutcomeClusters& clusters) {
  Cluster counts;
  for (const auto& cluster : clusters) {
    for (const ScoredOutcome& outcome : cluster) {
      counts.hits += outcome.success;
      ++counts.samples;
    }
  }
  return counts;
}

ForecastClusters ForecastsBy(const ScoreCurve& curve, const OutcomeClusters& clusters) {
  ForecastClusters forecasts;
  for (const auto& cluster : clusters) {
    auto& of_cluster = forecasts.emplace_back();
    for (const ScoredOutcome& outcome : cluster) {
      of_cluster.push_back({curve.At(outcome.score), outcome.success});
    }
  }
  return forecasts;
}

bool AreProbabilities(const OutcomeClusters& clusters) {
  return std::ranges::all_of(clusters, [](const auto& cluster) {
    return std::ranges::all_of(cluster, [](const ScoredOutcome& outcome) {
      return outcome.score >= 0 && outcome.score <= 1;
    });
  });
}

}  // namespace

ScoreCurve FitCurve(const OutcomeClusters& samples) {
  std::vector<ScoredOutcome> all;
  for (const auto& cluster : samples) all.insert(all.end(), cluster.begin(), cluster.end());
  const auto [lowest, highest] = std::ranges::minmax_element(all, {}, &ScoredOutcome::score);
  const double low = lowest->score, high = highest->score;
  all.push_back({low, true});
  all.push_back({high, false});
  ScoreCurve curve;
  for (const IsotonicBlock& block : PoolAdjacentViolators(all)) {
    curve.knots.push_back({block.first, block.rate});
    if (block.last > block.first) curve.knots.push_back({block.last, block.rate});
  }
  return curve;
}

std::string TooFewSamples(const OutcomeClusters& samples, const std::string& noun,
                          const std::string& hit) {
  const Cluster counts = CountsOf(samples);
  const auto bins = std::ranges::count_if(samples, [](const auto& bin) { return !bin.empty(); });
  if (bins < kMinCalibrationBins) {
    return fmt::format("has {}s in {} bins, but {} are needed; run more trials", noun, bins,
                       kMinCalibrationBins);
  }
  if (counts.samples < kMinCalibrationSamples) {
    return fmt::format("has {} {}s, but {} are needed; run more trials", counts.samples, noun,
                       kMinCalibrationSamples);
  }
  if (counts.hits == 0) {
    return fmt::format("has {} {}s, and none is {}; take an easier scenario", counts.samples, noun,
                       hit);
  }
  if (counts.hits == counts.samples) {
    return fmt::format("has {} {}s, and all are {}; take a harder scenario", counts.samples, noun,
                       hit);
  }
  return "";
}

FittedCurve FitAndValidate(const OutcomeClusters& samples) {
  OutcomeClusters clusters = samples;
  std::erase_if(clusters, [](const auto& cluster) { return cluster.empty(); });
  FittedCurve fitted;
  fitted.curve = FitCurve(clusters);
  const Cluster counts = CountsOf(clusters);
  fitted.samples = counts.samples;
  fitted.hits = counts.hits;
  const size_t folds = std::min<size_t>(kCalibrationFolds, clusters.size());
  std::vector<ScoreCurve> without_fold;
  for (size_t fold = 0; fold < folds; ++fold) {
    OutcomeClusters others;
    for (size_t c = 0; c < clusters.size(); ++c) {
      if (c % folds != fold) others.push_back(clusters[c]);
    }
    without_fold.push_back(FitCurve(others));
  }
  for (size_t c = 0; c < clusters.size(); ++c) {
    fitted.after.push_back(ForecastsBy(without_fold[c % folds], {clusters[c]}).front());
  }
  fitted.quality_after = QualityOf(fitted.after);
  if (!AreProbabilities(clusters)) return fitted;
  for (const auto& cluster : clusters) {
    auto& forecasts = fitted.before.emplace_back();
    for (const ScoredOutcome& outcome : cluster) {
      forecasts.push_back({outcome.score, outcome.success});
    }
  }
  fitted.quality_before = QualityOf(fitted.before);
  fitted.change = QualityDifference(fitted.before, fitted.after);
  return fitted;
}

CalibrationFit FitCalibration(CalibrationSamples samples) {
  const std::string fault = TooFewSamples(samples.poses, "pose", "right");
  CheckInput(fault.empty(), fmt::format("{} {}", samples.run, fault));
  CalibrationFit fit;
  fit.pose_right = FitAndValidate(samples.poses);
  fit.no_picks = TooFewSamples(samples.picks, "pick", "successful");
  if (fit.no_picks.empty()) fit.pick_succeeds = FitAndValidate(samples.picks);
  fit.samples = std::move(samples);
  return fit;
}

ScoreCalibration CalibrationOf(const CalibrationFit& fit) {
  const EstimatorSpec& estimator = fit.samples.estimator;
  ScoreCalibration calibration;
  calibration.run = fit.samples.run;
  calibration.estimator = estimator.name;
  calibration.mode = estimator.mode;
  calibration.model = estimator.model;
  calibration.command = estimator.command;
  calibration.scores = estimator.scores;
  calibration.min_score = estimator.min_score;
  calibration.bins = static_cast<int>(fit.pose_right.after.size());
  calibration.poses = fit.pose_right.samples;
  calibration.right = fit.pose_right.hits;
  calibration.pose_right = fit.pose_right.curve;
  const Cluster picks = CountsOf(fit.samples.picks);
  calibration.picks = picks.samples;
  calibration.picked = picks.hits;
  if (fit.pick_succeeds) calibration.pick_succeeds = fit.pick_succeeds->curve;
  return calibration;
}

}  // namespace pickbed::eval
