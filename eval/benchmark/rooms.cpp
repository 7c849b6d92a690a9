#include "eval/benchmark/rooms.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "eval/estimate/statistics.h"
#include "eval/frames/image_estimator.h"
#include "eval/trial/pose_matching.h"

namespace pickbed::eval {
namespace {

constexpr double kMinCountedScore = 0.05;  // of the poses that the calibration error counts

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

// Images of one row.
struct Group {
  ComparedRow all;       // poses from kMinCountedScore
  ComparedRow reported;  // poses from the minimum score
};

RoomsRow RowOf(const std::string& rooms, const std::string& background, const Group& group) {
  RoomsRow row{rooms, background};
  const ComparisonStatistics all = StatisticsOf(group.all);
  const ComparisonStatistics reported = StatisticsOf(group.reported);
  row.images = reported.bins;
  row.instances = reported.instances;
  row.recalled = reported.recalled;
  row.poses = reported.poses;
  row.right = reported.right;
  row.calibration_error = all.calibration_error;
  row.seconds = all.seconds;
  for (const ComparedImage& image : group.all.images) {
    for (const ScoredHypothesis& pose : image.score.hypotheses) {
      if (pose.recalled < 0) row.highest_false = std::max(row.highest_false, pose.record.score);
    }
  }
  return row;
}

const char* BackgroundName(bool given, bool found) {
  return given ? "given" : found ? "fitted" : "unknown";
}

double ShareOf(int hits, int samples, double without_samples) {
  return samples > 0 ? static_cast<double>(hits) / samples : without_samples;
}

}  // namespace

std::vector<RoomsRow> RunRooms(LabelledViewSource& views, const EstimatorSpec& spec,
                               const RoomsOptions& options,
                               const std::function<bool(int, int)>& on_progress) {
  const RoomKind kinds[] = {{"bin", "rooms/bin", Surroundings::kRoomAndBin, options.bins},
                            {"table", "rooms/table", Surroundings::kRoomNoBin, options.tables},
                            {"empty", "rooms/empty", Surroundings::kEmptyRoom, options.empty}};
  std::vector<MetricModel> metrics;
  for (const auto& model : views.objects()) metrics.push_back(MakeMetricModel(*model));
  EstimatorSpec low = spec;
  low.min_score = kMinCountedScore;
  std::optional<ImageEstimator> estimator;
  std::map<std::pair<std::string, std::string>, Group> groups;
  const int total = options.bins + options.tables + options.empty;
  int done = 0;
  for (const RoomKind& kind : kinds) {
    for (int i = 0; i < kind.images; ++i) {
      if (!on_progress(done, total)) return {};
      Rng rng = Rng::Derive(options.seed, i, kind.stream);
      const int objects = static_cast<int>(views.objects().size());
      const LabelledView view =
          views.ClutterScene({rng.Next(), 1, ObjectId(i % objects), true, kind.surroundings})
              .front();
      if (!estimator)
        estimator.emplace(ImageEstimatorSetup{views.objects(), low, "pcl_icp", options.threads},
                          view.frame);
      for (const bool given : {false, true}) {
        const EstimatorInput input{view.frame, given ? view.background : std::nullopt};
        Rng search = Rng::Derive(options.seed, i, "rooms/search");
        const auto start = std::chrono::steady_clock::now();
        const EstimateResult found = estimator->Estimate(input, search);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        ComparedImage all{done, ScoreOf(view, metrics, found.hypotheses), found.seconds};
        all.seconds["estimate"] = taken.count();
        std::vector<PoseHypothesis> reported = found.hypotheses;
        std::erase_if(reported, [&](const auto& pose) { return pose.score < spec.min_score; });
        const ComparedImage kept{done, ScoreOf(view, metrics, reported), all.seconds};
        const std::string background = BackgroundName(given, found.has_background);
        const auto add = [&](const std::string& rooms, const std::string& of) {
          Group& group = groups[{of, rooms}];
          group.all.images.push_back(all);
          group.reported.images.push_back(kept);
        };
        add(kind.name, given ? "given" : "all");
        add("all", background);
      }
      ++done;
    }
  }
  std::vector<RoomsRow> rows;
  for (const auto& [key, group] : groups) rows.push_back(RowOf(key.second, key.first, group));
  return rows;
}

std::string RoomsText(const std::vector<RoomsRow>& rows) {
  std::string text = fmt::format("{:<8}{:<12}{:>7}{:>11}{:>8}{:>7}{:>11}{:>13}{:>7}{:>10}{:>9}\n",
                                 "rooms", "background", "images", "instances", "recall", "poses",
                                 "precision", "false/image", "ECE", "max false", "seconds");
  for (const RoomsRow& row : rows) {
    text += fmt::format(
        "{:<8}{:<12}{:>7}{:>11}{:>8.3f}{:>7}{:>11.3f}{:>13.3f}{:>7.3f}{:>10.2f}"
        "{:>9.2f}\n",
        row.rooms, row.background, row.images, row.instances,
        ShareOf(row.recalled, row.instances, 0), row.poses, ShareOf(row.right, row.poses, 1),
        static_cast<double>(row.poses - row.right) / std::max(1, row.images), row.calibration_error,
        row.highest_false, row.seconds);
  }
  return text;
}

ResultColumns RoomsColumns() {
  return {
      {"rooms", "kind of the rooms: bin, table, empty (no object), or all"},
      {"background", "given, fitted (planes were found), unknown, or all that are not given"},
      {"images", "number of images"},
      {"instances", "number of instances at least 10 % visible"},
      {"recalled", "number of these that are recalled"},
      {"poses", "number of poses with at least the minimum score"},
      {"right", "number of these that are right"},
      {"calibration_error", "expected calibration error of all scores of at least 0.05", "0..1"},
      {"highest_false", "highest score of a wrong pose", "0..1"}};
}

std::string RoomsCsv(const std::vector<RoomsRow>& rows) {
  std::string csv = HeaderLine(RoomsColumns());
  for (const RoomsRow& row : rows) {
    csv += fmt::format("{},{},{},{},{},{},{},{:.4f},{:.4f}\n", row.rooms, row.background,
                       row.images, row.instances, row.recalled, row.poses, row.right,
                       row.calibration_error, row.highest_false);
  }
  return csv;
}

}  // namespace pickbed::eval
