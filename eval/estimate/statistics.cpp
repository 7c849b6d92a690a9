#include "eval/estimate/statistics.h"

#include <algorithm>
#include <cmath>

#include "eval/cell/simulated_cell.h"
#include "scenes/base/finite_counts.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

constexpr double kFarOff_deg = 15;
constexpr double kWantedPrecision = 0.95;
constexpr int kReliabilityBins = 10;

// A reported pose.
struct ReportedPose {
  double score = 0;
  bool right = false;   // correct, and the first pose of its instance
  bool counts = false;  // its instance is to be found
};

// Recall counts only instances to be found. Precision counts all poses.
double RecallAtPrecision(std::vector<ReportedPose> reported_poses, int wanted) {
  std::stable_sort(reported_poses.begin(), reported_poses.end(),
                   [](const ReportedPose& a, const ReportedPose& b) { return a.score > b.score; });
  int right = 0, found = 0;
  double best = 0;
  for (size_t i = 0; i < reported_poses.size(); ++i) {
    right += reported_poses[i].right;
    found += reported_poses[i].counts;
    // A threshold cannot separate equal scores.
    if (i + 1 < reported_poses.size() && reported_poses[i + 1].score == reported_poses[i].score)
      continue;
    if (right >= kWantedPrecision * static_cast<double>(i + 1)) best = found;
  }
  return wanted > 0 ? best / wanted : 0;
}

// Expected calibration error (Naeini, Cooper and Hauskrecht 2015).
void Calibrate(const std::vector<ReportedPose>& reported_poses, ComparisonStatistics& statistics) {
  statistics.reliability.resize(kReliabilityBins);
  for (const ReportedPose& pose : reported_poses) {
    const int bin =
        std::clamp(static_cast<int>(pose.score * kReliabilityBins), 0, kReliabilityBins - 1);
    statistics.reliability[bin].score_sum += pose.score;
    ++statistics.reliability[bin].count;
    statistics.reliability[bin].right += pose.right;
  }
  for (const ReliabilityBin& bin : statistics.reliability) {
    if (reported_poses.empty()) break;
    statistics.calibration_error += std::abs(bin.score_sum - bin.right) / reported_poses.size();
  }
}

void CountInstances(const AttemptScore& image, std::optional<ObjectId> object,
                    ComparisonStatistics& statistics) {
  for (const InstanceRecord& instance : image.instances) {
    if (object && instance.object != *object) continue;
    if (instance.visible_fraction < kCountedVisibility) continue;
    ++statistics.instances;
    statistics.recalled += instance.recalled;
    CountRecall(instance, statistics.bands);
  }
}

bool TopPosesRight(const AttemptScore& image) {
  if (image.hypotheses.size() < kTopPoses) return false;
  return std::all_of(image.hypotheses.begin(), image.hypotheses.begin() + kTopPoses,
                     [](const ScoredHypothesis& pose) { return pose.recalled >= 0; });
}

std::optional<double> TopPickChance(const ComparedRow& row) {
  double sum = 0;
  int known = 0, mapped = 0;
  for (const ComparedImage& image : row.images) {
    const bool no_pose = image.score.hypotheses.empty();
    if (!no_pose && (image.pick_chances.empty() || !image.pick_chances.front())) continue;
    ++known;
    if (no_pose) continue;
    ++mapped;
    sum += *image.pick_chances.front();
  }
  if (mapped == 0) return std::nullopt;
  return sum / known;
}

}  // namespace

ComparisonStatistics StatisticsOf(const ComparedRow& row, std::optional<ObjectId> object) {
  ComparisonStatistics statistics;
  statistics.bands = EmptyRecallBands();
  std::vector<ReportedPose> reported_poses;
  ValueClusters rotations_deg, mssds;  // by bin
  int far_off = 0, standing = 0;
  for (const ComparedImage& compared : row.images) {
    const AttemptScore& image = compared.score;
    ++statistics.bins;
    std::vector<double>& rotations_here_deg = rotations_deg.emplace_back();
    std::vector<double>& mssds_here = mssds.emplace_back();
    statistics.top_right += !image.hypotheses.empty() && image.hypotheses.front().record.correct;
    if (image.instances.size() >= kTopPoses) {
      ++statistics.top5_bins;
      statistics.top5_right += TopPosesRight(image);
    }
    CountInstances(image, object, statistics);
    for (const ScoredHypothesis& hypothesis : image.hypotheses) {
      const HypothesisRecord& pose = hypothesis.record;
      if (object && pose.object != *object) continue;
      const int taken = hypothesis.recalled;
      const bool counts =
          taken >= 0 && image.instances[taken].visible_fraction >= kCountedVisibility;
      reported_poses.push_back({pose.score, taken >= 0, counts});
      ++statistics.poses;
      statistics.right += taken >= 0;
      statistics.identity_right +=
          hypothesis.nearest >= 0 && image.instances[hypothesis.nearest].object == pose.object;
      if (pose.mssd_diameters() >= kMatchDiameters) continue;
      rotations_here_deg.push_back(Degrees(pose.rotation_rad()));
      mssds_here.push_back(pose.mssd_diameters());
      far_off += rotations_here_deg.back() > kFarOff_deg;
      ++standing;
    }
    for (const auto& [stage, seconds] : compared.seconds) {
      if (IsNotFiniteCount(stage)) continue;
      statistics.stages[stage] += seconds / static_cast<double>(row.images.size());
    }
  }
  statistics.recall_at_95 = RecallAtPrecision(reported_poses, statistics.instances);
  Calibrate(reported_poses, statistics);
  statistics.top_pick_chance = TopPickChance(row);
  statistics.share_over_15_deg = standing > 0 ? static_cast<double>(far_off) / standing : 0;
  statistics.median_rotation_deg = MedianWithin(rotations_deg);
  statistics.median_mssd_diameters = MedianWithin(mssds);
  if (const auto all = statistics.stages.find("estimate"); all != statistics.stages.end()) {
    statistics.seconds = all->second;
  }
  return statistics;
}

}  // namespace pickbed::eval
