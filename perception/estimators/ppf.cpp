#include "perception/estimators/ppf.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/surface_matching.hpp>
#include <opencv2/surface_matching/ppf_helpers.hpp>
#include <unordered_set>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/polish.h"
#include "perception/suppress.h"
#include "perception/verify.h"

namespace pickbed {
namespace {

using cv::ppf_match_3d::Pose3DPtr;

// Points with normals as OpenCV wants them: one row x y z nx ny nz a point.
class PointRows {
 public:
  void Add(const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
    for (const Eigen::Vector3f* v : {&p, &n}) {
      for (int i = 0; i < 3; ++i) values_.push_back((*v)[i]);
    }
  }
  int size() const { return static_cast<int>(values_.size() / 6); }
  cv::Mat ToMat() const { return cv::Mat(values_, true).reshape(1, size()); }

 private:
  std::vector<float> values_;
};

cv::Mat ModelMat(const ModelPoints& model) {
  PointRows rows;
  for (size_t i = 0; i < model.points_O.size(); ++i) {
    rows.Add(model.points_O[i], model.normals_O[i]);
  }
  return rows.ToMat();
}

// The first foreground point with a normal of each voxel.
PointRows SceneRows(const OrganizedCloud& cloud, double voxel_m) {
  PointRows rows;
  std::unordered_set<uint64_t> taken;
  for (const int pixel : cloud.foreground_pixels) {
    const Eigen::Vector3f& normal = cloud.normals_C[pixel];
    if (normal.isZero(0)) continue;
    const Eigen::Vector3f& p = cloud.points_C[pixel];
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<int64_t>(std::floor(p[axis] / voxel_m));
      key = key << 21 | (static_cast<uint64_t>(cell) & 0x1fffff);
    }
    if (taken.insert(key).second) rows.Add(p, normal);
  }
  return rows;
}

Pose ToPose(const cv::Matx44d& m) {
  Eigen::Matrix3d R;
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) R(row, col) = m(row, col);
    X.translation()[row] = m(row, 3);
  }
  X.linear() = Orthonormalized(R);
  return X;
}

// Share of what should be seen that is, less what is looked through; a pose that rests on a few
// points only is worth less.
double ScoreOf(const FitReport& fit, double full_support) {
  const double expected = 1 - fit.hidden_share;
  if (expected <= 0) return 0;
  const double agreement = (fit.inlier_share - fit.violated_share) / expected;
  return std::clamp(agreement * std::min(1.0, fit.inlier_share / full_support), 0.0, 1.0);
}

template <typename Work>
auto Timed(StageSeconds& seconds, const char* stage, Work work) {
  const StageTimer timer(seconds, stage);
  return work();
}

class PpfEstimator : public PoseEstimator {
 public:
  explicit PpfEstimator(const EstimatorSetup& setup)
      : min_score_(setup.spec.min_score), refiner_(setup.refiner) {
    for (const auto& object : setup.objects) {
      models_.push_back(MakeModelPoints(*object));
      model_mats_.push_back(ModelMat(models_.back()));
      detectors_.push_back(
          std::make_unique<cv::ppf_match_3d::PPF3DDetector>(options_.model_sampling));
      detectors_.back()->setSearchParams(options_.cluster_m,
                                         options_.cluster_deg * std::numbers::pi / 180);
      detectors_.back()->trainModel(model_mats_.back());
    }
  }

  EstimateResult Estimate(const EstimatorInput& input, Rng&) override {
    EstimateResult result;
    const OrganizedCloud cloud =
        Timed(result.seconds, "cloud", [&] { return BuildCloud(input.frame, input.background); });
    const PointRows rows = SceneRows(cloud, options_.scene_voxel_m);
    if (rows.size() < kMinScenePoints) return result;
    const cv::Mat scene = rows.ToMat();
    std::vector<PoseHypothesis> found;
    for (size_t object = 0; object < models_.size(); ++object) {
      std::vector<Pose3DPtr> poses =
          Timed(result.seconds, "match", [&] { return Match(object, scene); });
      Timed(result.seconds, "icp", [&] { RefineAll(object, scene, poses); });
      Timed(result.seconds, "verify", [&] { Score(object, cloud, poses, found); });
    }
    result.hypotheses = Timed(result.seconds, "suppress",
                              [&] { return SuppressDuplicates(cloud, models_, std::move(found)); });
    Timed(result.seconds, "refine",
          [&] { PolishPoses(refiner_, cloud, models_, {}, result.hypotheses); });
    return result;
  }

 private:
  static constexpr int kMinScenePoints = 30;  // fewer hold no part, and OpenCV wants some

  // The poses with most votes.
  std::vector<Pose3DPtr> Match(size_t object, const cv::Mat& scene) const {
    std::vector<Pose3DPtr> poses;
    detectors_[object]->match(scene, poses, options_.scene_step, options_.scene_distance);
    if (static_cast<int>(poses.size()) > options_.max_poses) poses.resize(options_.max_poses);
    return poses;
  }

  void RefineAll(size_t object, const cv::Mat& scene, std::vector<Pose3DPtr>& poses) const {
    cv::ppf_match_3d::ICP icp(options_.icp_iterations, options_.icp_tolerance,
                              options_.icp_rejection, options_.icp_levels);
    if (!poses.empty()) icp.registerModelToScene(model_mats_[object], scene, poses);
  }

  // Appends the poses that reach the least score.
  void Score(size_t object, const OrganizedCloud& cloud, const std::vector<Pose3DPtr>& poses,
             std::vector<PoseHypothesis>& found) const {
    for (const Pose3DPtr& pose : poses) {
      PoseHypothesis h;
      h.object = static_cast<int>(object);
      h.X_CO = ToPose(pose->pose);
      if (!h.X_CO.matrix().allFinite()) continue;
      h.fit = MeasureFit(cloud, models_[object], h.X_CO);
      h.score = ScoreOf(h.fit, options_.full_support);
      if (h.score >= min_score_) found.push_back(h);
    }
  }

  PpfOptions options_;
  double min_score_;
  std::string refiner_;
  std::vector<ModelPoints> models_;
  std::vector<cv::Mat> model_mats_;
  std::vector<std::unique_ptr<cv::ppf_match_3d::PPF3DDetector>> detectors_;
};

}  // namespace

std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup) {
  return std::make_unique<PpfEstimator>(setup);
}

}  // namespace pickbed
