#include "eval/benchmark/rooms.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "eval/estimate/statistics.h"
#include "eval/frames/image_estimator.h"

namespace pickbed::eval {
namespace {

constexpr char kAll[] = "all";

struct RoomKind {
  const char* name;
  const char* stream;  // of random numbers
  Surroundings surroundings;
  int images;
};

// Ground truth and poses are in the camera frame, so the world frame is the camera frame.
AttemptScore ScoreOf(const LabelledView& view, const std::vector<MetricModel>& metrics,
                     const std::vector<PoseHypothesis>& poses) {
  std::vector<TrueInstance> instances;
  for (size_t i = 0; i < view.instances.size(); ++i) {
    const LabelledInstance& instance = view.instances[i];
    instances.push_back({instance.object, instance.X_CO, instance.visible_fraction,
                         InstanceId(static_cast<int>(i))});
  }
  const InstanceMatcher matcher(metrics, std::move(instances));
  return ScoreAgainstTruth(matcher, Camera{view.frame.intrinsics, Pose::Identity()}, poses);
}

std::vector<ForecastOutcome> ForecastsOf(const RoomEstimate& estimate) {
  std::vector<ForecastOutcome> forecasts;
  for (const ScoredHypothesis& pose : estimate.image.score.hypotheses) {
    forecasts.push_back({pose.record.score, pose.recalled >= 0});
  }
  return forecasts;
}

RoomsRow RowOf(const std::string& rooms, const std::string& background,
               const std::vector<const RoomEstimate*>& estimates, double min_score) {
  RoomsRow row{rooms, background};
  ComparedRow reported;
  ForecastClusters forecasts;
  for (const RoomEstimate* estimate : estimates) {
    forecasts.push_back(ForecastsOf(*estimate));
    ComparedImage image = estimate->image;
    for (const ScoredHypothesis& pose : image.score.hypotheses) {
      if (pose.recalled < 0) row.highest_false = std::max(row.highest_false, pose.record.score);
    }
    KeepReported(min_score, image.score);
    reported.images.push_back(std::move(image));
  }
  const ComparisonStatistics statistics = StatisticsOf(reported);
  row.images = statistics.bins;
  row.instances = statistics.instances;
  row.recalled = statistics.recalled;
  row.poses = statistics.poses;
  row.right = statistics.right;
  row.seconds = statistics.seconds;
  row.calibration_error = QualityOf(forecasts).calibration_error;
  return row;
}

double ShareOf(int hits, int samples, double without_samples) {
  return samples > 0 ? static_cast<double>(hits) / samples : without_samples;
}

}  // namespace

void KeepReported(double min_score, AttemptScore& score) {
  // By decreasing score, each pose recalls a free instance. So a low score changes no higher pose.
  std::erase_if(score.hypotheses,
                [&](const ScoredHypothesis& pose) { return pose.record.score < min_score; });
  for (InstanceRecord& instance : score.instances) instance.recalled = false;
  for (const ScoredHypothesis& pose : score.hypotheses) {
    if (pose.recalled >= 0) score.instances[pose.recalled].recalled = true;
  }
}

std::vector<RoomEstimate> EstimateRooms(LabelledViewSource& views, const EstimatorSpec& spec,
                                        const RoomsOptions& options,
                                        const RoomsCallbacks& callbacks) {
  constexpr int kWithoutPlanes = 2;  // every second image
  const RoomKind kinds[] = {{"bin", "rooms/bin", Surroundings::kRoomAndBin, options.bins},
                            {"table", "rooms/table", Surroundings::kRoomNoBin, options.tables},
                            {"empty", "rooms/empty", Surroundings::kEmptyRoom, options.empty}};
  std::vector<MetricModel> metrics;
  for (const auto& model : views.objects()) metrics.push_back(MakeMetricModel(*model));
  EstimatorSpec low = spec;
  low.min_score = kMinRoomScore;
  std::optional<ImageEstimator> estimator;
  std::vector<RoomEstimate> estimates;
  const int total = options.bins + options.tables + options.empty;
  int done = 0;
  for (const RoomKind& kind : kinds) {
    for (int i = 0; i < kind.images; ++i, ++done) {
      if (!callbacks.on_progress(done, total)) return {};
      Rng rng = Rng::Derive(options.seed, i, kind.stream);
      const int objects = static_cast<int>(views.objects().size());
      const LabelledView view =
          views.ClutterScene({rng.Next(), 1, ObjectId(i % objects), true, kind.surroundings})
              .front();
      if (!estimator)
        estimator.emplace(ImageEstimatorSetup{views.objects(), low, "pcl_icp", options.threads},
                          view.frame);
      const auto estimate = [&](bool given, bool fits_background) {
        EstimatorInput input{view.frame, given ? view.background : std::nullopt};
        input.fits_background = fits_background;
        Rng search = Rng::Derive(options.seed, i, "rooms/search");
        const auto start = std::chrono::steady_clock::now();
        const EstimateResult found = estimator->Estimate(input, search);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        ComparedImage image{done, ScoreOf(view, metrics, found.hypotheses), found.seconds};
        image.seconds["estimate"] = taken.count();
        const char* background = given                  ? kGivenBackground
                                 : found.has_background ? kFittedBackground
                                                        : kUnknownBackground;
        estimates.push_back({kind.name, background, fits_background, std::move(image)});
        if (callbacks.on_estimate) callbacks.on_estimate(view, estimates.back());
      };
      estimate(true, true);
      estimate(false, true);
      if (i % kWithoutPlanes == 0) estimate(false, false);
    }
  }
  return estimates;
}

std::vector<RoomsRow> RoomsRowsOf(const std::vector<RoomEstimate>& estimates, double min_score) {
  std::map<std::pair<std::string, std::string>, std::vector<const RoomEstimate*>> groups;
  for (const RoomEstimate& estimate : estimates) {
    const bool given = estimate.background == kGivenBackground;
    groups[{estimate.background, kAll}].push_back(&estimate);
    if (!estimate.fits_background) continue;
    groups[{given ? kGivenBackground : kAll, estimate.rooms}].push_back(&estimate);
  }
  std::vector<RoomsRow> rows;
  for (const auto& [key, group] : groups) {
    rows.push_back(RowOf(key.second, key.first, group, min_score));
  }
  return rows;
}

std::string RoomsText(const std::vector<RoomsRow>& rows) {
  std::string text = fmt::format("{:<8}{:<12}{:>7}{:>11}{:>8}{:>7}{:>11}{:>13}{:>21}{:>10}{:>9}\n",
                                 "rooms", "background", "images", "instances", "recall", "poses",
                                 "precision", "false/image", "ECE [95 %]", "max false", "seconds");
  for (const RoomsRow& row : rows) {
    const Interval& interval = row.calibration_error.ci95;
    std::string error = fmt::format("{:.3f}", row.calibration_error.value);
    if (interval.is_known()) error += fmt::format(" [{:.3f}, {:.3f}]", interval.low, interval.high);
    text += fmt::format(
        "{:<8}{:<12}{:>7}{:>11}{:>8.3f}{:>7}{:>11.3f}{:>13.3f}{:>21}{:>10.2f}{:>9.2f}\n", row.rooms,
        row.background, row.images, row.instances, ShareOf(row.recalled, row.instances, 0),
        row.poses, ShareOf(row.right, row.poses, 1),
        static_cast<double>(row.poses - row.right) / std::max(1, row.images), error,
        row.highest_false, row.seconds);
  }
  return text;
}

ResultColumns RoomsColumns() {
  return {
      {"rooms", "kind of the rooms: bin, table, empty (no object), or all"},
      {"background",
       "given, fitted (planes were found), unknown (none was found or looked for), or all that are "
       "not given and in which planes were looked for"},
      {"images", "number of images"},
      {"instances", "number of instances at least 10 % visible"},
      {"recalled", "number of these that are recalled"},
      {"poses", "number of poses with at least the minimum score"},
      {"right", "number of these that are right"},
      {"calibration_error", "expected calibration error of all scores of at least 0.05", "0..1"},
      {"calibration_error_low", "lower end of its 95 % interval; empty with few images", "0..1"},
      {"calibration_error_high", "upper end of its 95 % interval; empty with few images", "0..1"},
      {"highest_false", "highest score of a wrong pose", "0..1"}};
}

std::string RoomsCsv(const std::vector<RoomsRow>& rows) {
  std::string csv = HeaderLine(RoomsColumns());
  for (const RoomsRow& row : rows) {
    const Interval& interval = row.calibration_error.ci95;
    const std::string ends =
        interval.is_known() ? fmt::format("{:.4f},{:.4f}", interval.low, interval.high) : ",";
    csv += fmt::format("{},{},{},{},{},{},{},{:.4f},{},{:.4f}\n", row.rooms, row.background,
                       row.images, row.instances, row.recalled, row.poses, row.right,
                       row.calibration_error.value, ends, row.highest_false);
  }
  return csv;
}

}  // namespace pickbed::eval
