#include "eval/report/run_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "eval/cell/simulated_cell.h"
#include "eval/metrics/metric_table.h"
#include "eval/page/ticks.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/finite_counts.h"

namespace pickbed::eval {
namespace {

constexpr double kLowShare = 0.1, kHighShare = 0.9;  // percentiles of StageTime

// Counts one cluster per trial, for the rate and its interval.
class RateByScene {
 public:
  explicit RateByScene(size_t trials) : clusters_(trials) {}
  void Count(size_t trial, bool hit) {
    clusters_[trial].hits += hit;
    ++clusters_[trial].samples;
  }
  ReportRate Finish() const { return ClusterRate(clusters_); }

 private:
  std::vector<Cluster> clusters_;
};

// Returns the nearest value of a sorted list.
double Quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<size_t>(std::lround(share * static_cast<double>(sorted.size() - 1)))];
}

const InstanceRecord* InstanceIn(const AttemptRecord& pick, InstanceId instance) {
  const auto found = std::find_if(pick.instances.begin(), pick.instances.end(),
                                  [&](const InstanceRecord& r) { return r.instance == instance; });
  return found == pick.instances.end() ? nullptr : &*found;
}

bool MatchesAnInstance(const HypothesisRecord& score) {
  return score.instance >= 0 && std::isfinite(score.mssd_diameters());
}

ReportRate RateOfScenes(const ConfigurationTrials& configuration, const TrialCount& count) {
  return ClusterRate(CountByScene(configuration.trials, count));
}

std::vector<BandRates> BandsOf(const ConfigurationTrials& configuration) {
  std::vector<BandRates> rates;
  for (const VisibleBand& band : configuration.bands) {
    rates.push_back({band, RateOfScenes(configuration, InstancesRecalled(band.min, band.max)),
                     RateOfScenes(configuration, SuccessByVisibility(band.min, band.max)),
                     RateOfScenes(configuration, TargetsPicked(band.min, band.max))});
  }
  return rates;
}

template <typename Use>
void ForEachPose(const ConfigurationTrials& configuration, Use use) {
  for (size_t t = 0; t < configuration.trials.size(); ++t) {
    for (const AttemptRecord& pick : configuration.trials[t].attempts) {
      if (!pick.has_own_image()) continue;
      for (const HypothesisRecord& score : pick.hypotheses) use(t, score);
    }
  }
}

// A pose error in the unit of its histogram.
struct ReportedError {
  ErrorHistogram empty;  // with key, title and unit
  double factor = 1;

  double Of(const HypothesisRecord& score) const {
    return factor * score.metrics.Get(empty.metric);
  }
};

// The title of a histogram says "Pose error".
std::string WithoutError(const std::string& title) {
  constexpr std::string_view kError = " error";
  return title.ends_with(kError) ? title.substr(0, title.size() - kError.size()) : title;
}

// True if there are hypotheses, but none has a value of the metric.
bool IsUnrecorded(std::span<const ConfigurationTrials> configurations, const std::string& metric) {
  bool any_pose = false, any_value = false;
  for (const ConfigurationTrials& configuration : configurations) {
    ForEachPose(configuration, [&](size_t, const HypothesisRecord& score) {
      any_pose = true;
      any_value = any_value || !std::isnan(score.metrics.Get(metric));
    });
  }
  return any_pose && !any_value;
}

std::vector<ReportedError> ReportedErrors(std::span<const ConfigurationTrials> configurations) {
  std::vector<ReportedError> errors;
  for (const MetricRow& row : MetricsIn(kReported, {kMssdDiameters, kTranslation_m})) {
    const ShownUnit unit = ShownUnitOf(row);
    ReportedError error;
    error.empty.metric = MetricKey(row);
    error.empty.title = WithoutError(row.title);
    error.empty.unit = unit.name;
    error.empty.digits = unit.digits;
    error.factor = unit.Factor();
    if (!IsUnrecorded(configurations, error.empty.metric)) errors.push_back(error);
  }
  return errors;
}

std::vector<double> ErrorsOf(std::span<const ConfigurationTrials> configurations,
                             const ReportedError& error) {
  std::vector<double> errors;
  for (const ConfigurationTrials& configuration : configurations) {
    ForEachPose(configuration, [&](size_t, const HypothesisRecord& score) {
      if (MatchesAnInstance(score) && std::isfinite(error.Of(score))) {
        errors.push_back(error.Of(score));
      }
    });
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

// Returns a round upper limit that `error_share` of the errors do not exceed.
double RangeOf(std::span<const ConfigurationTrials> configurations, const ReportedError& error,
               const ReportOptions& options) {
  const double errors = Quantile(ErrorsOf(configurations, error), options.error_share);
  if (!(errors > 0)) return 1;
  // Errors below the last shown decimal are rounding.
  const double reach = std::max(errors, std::pow(10.0, 1 - error.empty.digits));
  const std::vector<double> ticks = RoundTicks(0, reach);
  const double step = ticks.size() > 1 ? ticks[1] : reach;
  return std::max(step, step * std::ceil(reach / step));
}

std::vector<BandError> ErrorsByBand(const ConfigurationTrials& configuration,
                                    const ReportedError& reported) {
  std::vector<BandError> errors(configuration.bands.size());
  std::vector<ValueClusters> values(errors.size(), ValueClusters(configuration.trials.size()));
  for (size_t t = 0; t < configuration.trials.size(); ++t) {
    for (const AttemptRecord& attempt : configuration.trials[t].attempts) {
      if (!attempt.has_own_image()) continue;
      for (const HypothesisRecord& pose : attempt.hypotheses) {
        const InstanceRecord* instance = InstanceIn(attempt, pose.instance);
        const double error = reported.Of(pose);
        if (instance == nullptr || !MatchesAnInstance(pose) || !std::isfinite(error)) continue;
        // In an occlusion trial only the target counts, as in BandRates.
        if (attempt.target >= 0 && pose.instance != attempt.target) continue;
        for (size_t b = 0; b < errors.size(); ++b) {
          if (!configuration.bands[b].Holds(instance->visible_fraction)) continue;
          values[b][t].push_back(error);
          ++errors[b].poses;
          break;
        }
      }
    }
  }
  for (size_t b = 0; b < errors.size(); ++b) errors[b].median = MedianWithin(values[b]);
  return errors;
}

ErrorHistogram HistogramOf(const ConfigurationTrials& configuration, const ReportedError& reported,
                           double range, const ReportOptions& options) {
  ErrorHistogram histogram = reported.empty;
  const int count = options.error_bins;
  for (int i = 0; i < count; ++i) {
    histogram.bins.push_back({range * i / count, range * (i + 1) / count, 0, 0});
  }
  ValueClusters errors(configuration.trials.size());
  ForEachPose(configuration, [&](size_t trial, const HypothesisRecord& score) {
    const double error = reported.Of(score);
    if (!MatchesAnInstance(score) || !std::isfinite(error)) return;
    errors[trial].push_back(error);
    ++histogram.total;
    if (error >= range) {
      ++histogram.beyond;
      return;
    }
    ErrorBin& bin = histogram.bins[static_cast<size_t>(error / range * count)];
    ++(score.correct ? bin.right : bin.wrong);
  });
  histogram.median = MedianWithin(errors);
  histogram.by_band = ErrorsByBand(configuration, reported);
  return histogram;
}

// Returns the largest number of attempts in one bin.
int MaxAttempts(std::span<const ConfigurationTrials> configurations) {
  size_t maximum = 0;
  for (const ConfigurationTrials& configuration : configurations) {
    for (const TrialResult& trial : configuration.trials) {
      maximum = std::max(maximum, trial.attempts.size());
    }
  }
  return static_cast<int>(maximum);
}

// `attempts`: largest number of attempts of all configurations, so that they have equal ranges.
std::vector<AttemptRange> AttemptRangesOf(const ConfigurationTrials& configuration, int attempts) {
  const int length = (attempts + kAttemptRanges - 1) / kAttemptRanges;
  std::vector<AttemptRange> ranges;
  for (int first = 0; first < attempts; first += length) {
    RateByScene picked(configuration.trials.size());
    const int end = std::min(first + length, attempts);
    for (size_t t = 0; t < configuration.trials.size(); ++t) {
      const std::vector<AttemptRecord>& records = configuration.trials[t].attempts;
      for (int i = first; i < std::min(end, static_cast<int>(records.size())); ++i) {
        picked.Count(t, records[i].failure == FailureReason::kNone);
      }
    }
    ranges.push_back({first, end - 1, picked.Finish()});
  }
  return ranges;
}

std::map<std::string, int64_t> RejectedOf(const ConfigurationTrials& configuration) {
  std::map<std::string, int64_t> rejected;
  for (const TrialResult& trial : configuration.trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      for (const auto& [cause, grasps] : attempt.grasps_rejected) rejected[cause] += grasps;
    }
  }
  return rejected;
}

Calibration CalibrationOf(const ConfigurationTrials& configuration, const ReportOptions& options) {
  const int count = options.confidence_bins;
  std::vector<RateByScene> right(count, RateByScene(configuration.trials.size()));
  std::vector<double> confidence(count, 0.0);
  Calibration calibration;
  ForEachPose(configuration, [&](size_t trial, const HypothesisRecord& score) {
    const int bin = std::clamp(static_cast<int>(score.score * count), 0, count - 1);
    right[bin].Count(trial, score.correct);
    confidence[bin] += score.score;
    ++calibration.poses;
  });
  for (int i = 0; i < count; ++i) {
    ConfidenceBin bin{0, right[i].Finish()};
    if (bin.right.samples == 0) continue;
    bin.mean_confidence = confidence[i] / bin.right.samples;
    calibration.expected_error +=
        std::abs(bin.mean_confidence - bin.right.rate()) * bin.right.samples / calibration.poses;
    calibration.bins.push_back(bin);
  }
  return calibration;
}

std::vector<StageTime> SecondsOf(const ConfigurationTrials& configuration) {
  std::map<std::string, std::vector<double>> of_stage;
  for (const TrialResult& trial : configuration.trials) {
    for (const auto& [stage, seconds] : trial.seconds) {
      if (!IsNotFiniteCount(stage)) of_stage[stage].push_back(seconds);
    }
  }
  std::vector<StageTime> times;
  for (auto& [stage, seconds] : of_stage) {
    const double mean =
        std::accumulate(seconds.begin(), seconds.end(), 0.0) / configuration.trials.size();
    seconds.resize(configuration.trials.size(),
                   0.0);  // trials that did not reach the stage count as 0
    std::sort(seconds.begin(), seconds.end());
    times.push_back({stage, mean, Quantile(seconds, kLowShare), Quantile(seconds, kHighShare)});
  }
  // Mean seconds and name of the top-level stage.
  const auto whole = [&](const std::string& stage) {
    const std::string name = stage.substr(0, stage.find('/'));
    const auto found = std::find_if(times.begin(), times.end(),
                                    [&](const StageTime& time) { return time.stage == name; });
    return std::pair(found == times.end() ? 0 : found->mean_s, name);
  };
  std::map<std::string, std::pair<double, std::string>> wholes;
  for (const StageTime& time : times) wholes[time.stage] = whole(time.stage);
  std::sort(times.begin(), times.end(), [&](const StageTime& a, const StageTime& b) {
    const auto &whole_a = wholes[a.stage], &whole_b = wholes[b.stage];
    if (whole_a != whole_b) return whole_a > whole_b;
    const bool is_substage_a = a.stage != whole_a.second, is_substage_b = b.stage != whole_b.second;
    return is_substage_a != is_substage_b ? is_substage_b : a.mean_s > b.mean_s;
  });
  return times;
}

struct ObjectCounts {
  explicit ObjectCounts(size_t trials) : recall(trials), picks(trials), mssd(trials) {}
  ObjectReport report;
  RateByScene recall, picks;
  ValueClusters mssd;
  std::map<FailureReason, int> failures;
};

void CountImage(size_t trial, const AttemptRecord& pick, std::vector<ObjectCounts>& counts) {
  for (const InstanceRecord& instance : pick.instances) {
    // In an occlusion trial only the target counts, as in InstancesRecalled.
    if (pick.target >= 0 && instance.instance != pick.target) continue;
    if (instance.visible_fraction < kCountedVisibility || pick.pose_free) continue;
    counts.at(instance.object).recall.Count(trial, instance.recalled);
  }
  for (const HypothesisRecord& score : pick.hypotheses) {
    if (MatchesAnInstance(score))
      counts.at(score.object).mssd[trial].push_back(score.mssd_diameters());
  }
}

void CountAttempt(size_t trial, const AttemptRecord& pick, std::vector<ObjectCounts>& counts) {
  if (pick.has_own_image()) CountImage(trial, pick, counts);
  const InstanceRecord* target = pick.grasp ? InstanceIn(pick, pick.matched_instance) : nullptr;
  if (target != nullptr)
    counts.at(target->object).picks.Count(trial, pick.failure == FailureReason::kNone);
}

std::vector<ObjectReport> ObjectsOf(const ConfigurationTrials& configuration) {
  std::vector<ObjectCounts> counts(configuration.objects.size(),
                                   ObjectCounts(configuration.trials.size()));
  for (size_t t = 0; t < configuration.trials.size(); ++t) {
    for (const AttemptRecord& pick : configuration.trials[t].attempts)
      CountAttempt(t, pick, counts);
    for (const InstanceOutcome& instance_outcome : configuration.trials[t].outcomes) {
      ObjectCounts& count = counts.at(instance_outcome.object);
      ++count.report.dropped;
      count.report.picked += instance_outcome.picked;
      if (instance_outcome.failure != FailureReason::kNone)
        ++count.failures[instance_outcome.failure];
    }
  }
  std::vector<ObjectReport> objects;
  for (size_t i = 0; i < counts.size(); ++i) {
    ObjectCounts& count = counts[i];
    ObjectReport& report = count.report;
    report.name = configuration.objects[i];
    report.recall = count.recall.Finish();
    report.picks = count.picks.Finish();
    report.median_mssd_diameters = MedianWithin(count.mssd);
    const auto maximum =
        std::max_element(count.failures.begin(), count.failures.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (maximum != count.failures.end()) report.commonest = maximum->first;
    // Distractors have neither instances to recall nor dropped wanted instances.
    if (report.recall.samples + report.dropped > 0) objects.push_back(report);
  }
  return objects;
}

}  // namespace

void ReportOptions::Validate() const {
  const auto within = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw std::logic_error(fmt::format("ReportOptions::{} is {}", name, value));
  };
  within("confidence_bins", confidence_bins, 2, 100);
  within("error_bins", error_bins, 2, 200);
  within("error_share", error_share, 0.5, 1);
  within("failures", failures, 0, 5000);
  within("picture.width_px", picture.width_px, 64, 4096);
  within("picture.quality", picture.quality, 1, 100);
  within("pictures_mb", pictures_mb, 0, 100);
  within("views", views, 0, 20);
  within("views_mb", views_mb, 0, 100);
  within("animations", animations, 0, 20);
  within("animations_mb", animations_mb, 0, 100);
  within("cloud_points", cloud_points, 0, 1000000);
  within("view_triangles", view_triangles, 100, 1000000);
}

std::vector<ConfigurationReport> ReportOn(std::span<const ConfigurationTrials> configurations,
                                          const ReportOptions& options) {
  options.Validate();
  std::vector<double> ranges;
  const std::vector<ReportedError> errors = ReportedErrors(configurations);
  for (const ReportedError& error : errors)
    ranges.push_back(RangeOf(configurations, error, options));
  const int attempts = MaxAttempts(configurations);
  std::vector<ConfigurationReport> reports;
  for (const ConfigurationTrials& configuration : configurations) {
    ConfigurationReport& report = reports.emplace_back();
    report.name = configuration.name;
    report.summary = Summarize(configuration.trials, configuration.cycle, configuration.bands);
    if (HasTargets(configuration.trials)) {
      report.summary.hidden = StatisticsByHiddenShare(configuration.trials);
    }
    report.attempts = SharesOfAttempts(configuration.trials);
    report.bands = BandsOf(configuration);
    for (size_t i = 0; i < errors.size(); ++i) {
      report.errors.push_back(HistogramOf(configuration, errors[i], ranges[i], options));
    }
    report.calibration = CalibrationOf(configuration, options);
    report.seconds = SecondsOf(configuration);
    report.attempt_ranges = AttemptRangesOf(configuration, attempts);
    report.rejected = RejectedOf(configuration);
    report.objects = ObjectsOf(configuration);
  }
  return reports;
}

std::vector<FailedPick> FailedPicksOf(std::span<const ConfigurationTrials> configurations) {
  std::vector<FailedPick> failed;
  for (size_t p = 0; p < configurations.size(); ++p) {
    for (const TrialResult& trial : configurations[p].trials) {
      for (const AttemptRecord& pick : trial.attempts) {
        if (pick.failure == FailureReason::kNone) continue;
        FailedPick& entry = failed.emplace_back();
        entry.configuration = static_cast<int>(p);
        entry.trial = trial.trial;
        entry.attempt = pick.attempt;
        entry.failure = pick.failure;
        const InstanceRecord* instance =
            InstanceIn(pick, pick.target >= 0 ? pick.target : pick.matched_instance);
        if (instance != nullptr && (pick.grasp || pick.target >= 0)) {
          entry.visible_fraction = instance->visible_fraction;
        }
        if (!pick.grasp || pick.chosen < 0) continue;
        const HypothesisRecord& chosen = pick.hypotheses.at(pick.chosen);
        entry.object = configurations[p].objects.at(chosen.object);
        entry.confidence = chosen.score;
        if (MatchesAnInstance(chosen)) entry.mssd_diameters = chosen.mssd_diameters();
      }
    }
  }
  return failed;
}

std::vector<FailedPick> SpreadOverReasons(const std::vector<FailedPick>& picks, int maximum) {
  std::map<FailureReason, int> seen;
  // Number of earlier failures of the same reason, and index.
  std::vector<std::pair<int, size_t>> order;
  for (size_t i = 0; i < picks.size(); ++i) order.push_back({seen[picks[i].failure]++, i});
  std::sort(order.begin(), order.end());
  if (order.size() > static_cast<size_t>(maximum)) order.resize(maximum);
  std::sort(order.begin(), order.end(), [](auto& a, auto& b) { return a.second < b.second; });
  std::vector<FailedPick> spread;
  for (const auto& [rank, place] : order) spread.push_back(picks[place]);
  return spread;
}

std::vector<VisibleBand> BandsOfAll(std::span<const ConfigurationReport> configurations) {
  std::vector<VisibleBand> bands;
  for (const ConfigurationReport& configuration : configurations) {
    for (const BandRates& of_band : configuration.bands) bands.push_back(of_band.band);
  }
  const auto ends = [](const VisibleBand& band) { return std::pair(band.min, band.max); };
  std::sort(bands.begin(), bands.end(),
            [&](const VisibleBand& a, const VisibleBand& b) { return ends(a) < ends(b); });
  bands.erase(std::unique(bands.begin(), bands.end()), bands.end());
  return bands;
}

std::vector<std::string> NamesOf(std::span<const ConfigurationReport> configurations) {
  std::vector<std::string> names;
  for (const ConfigurationReport& configuration : configurations)
    names.push_back(configuration.name);
  return names;
}

}  // namespace pickbed::eval
