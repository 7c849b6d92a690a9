#include "perception/estimators/ppf_matcher.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/surface_matching.hpp>
#include <opencv2/surface_matching/ppf_helpers.hpp>
#include <unordered_set>

#include "scenes/base/math.h"

namespace pickbed::perception {
namespace {

using cv::ppf_match_3d::Pose3D;
using cv::ppf_match_3d::Pose3DPtr;

constexpr int kRow = 6;            // x y z nx ny nz
constexpr size_t kMinPoints = 30;  // OpenCV needs some points; fewer do not show an object

void AddRow(const Eigen::Vector3f& p, const Eigen::Vector3f& n, std::vector<float>& rows) {
  rows.insert(rows.end(), {p.x(), p.y(), p.z(), n.x(), n.y(), n.z()});
}

cv::Mat ToMat(const std::vector<float>& rows) {
  return cv::Mat(rows, true).reshape(1, static_cast<int>(rows.size() / kRow));
}

cv::Mat ModelMat(const ModelPoints& model) {
  std::vector<float> rows;
  for (size_t i = 0; i < model.points_O.size(); ++i) {
    AddRow(model.points_O[i], model.normals_O[i], rows);
  }
  return ToMat(rows);
}

Pose ToPose(const cv::Matx44d& m) {
  Eigen::Matrix3d R;
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) R(row, col) = m(row, col);
    X.translation()[row] = m(row, 3);
  }
  X.linear() = R.allFinite() ? Orthonormalized(R) : R;
  return X;
}

cv::Matx44d FromPose(const Pose& X) {
  cv::Matx44d m;
  for (int row = 0; row < 4; ++row) {
    for (int col = 0; col < 4; ++col) m(row, col) = X.matrix()(row, col);
  }
  return m;
}

// Returns OpenCV's sampling step, a share of the scene's bounding box per axis. The scene is
// already sampled, so the step is half a voxel at the longest side, but at least kFinest.
double OwnSampling(const std::vector<float>& rows, double voxel_m) {
  constexpr double kFinest = 0.008;
  float longest_m = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float low = rows[axis], high = rows[axis];
    for (size_t i = axis; i < rows.size(); i += kRow) {
      low = std::min(low, rows[i]);
      high = std::max(high, rows[i]);
    }
    longest_m = std::max(longest_m, high - low);
  }
  return std::clamp(0.5 * voxel_m / std::max<double>(longest_m, voxel_m), kFinest, 0.5);
}

// Returns whether the points differ along each axis. OpenCV divides by their extent.
bool HasVolume(const std::vector<float>& rows) {
  for (int axis = 0; axis < 3; ++axis) {
    bool differs = false;
    for (size_t i = axis; i < rows.size() && !differs; i += kRow) differs = rows[i] != rows[axis];
    if (!differs) return false;
  }
  return true;
}

// Splits the points into square windows in x and y, half a side apart. Anything at most half a side
// wide is completely inside one window.
std::vector<std::vector<float>> Windows(const std::vector<float>& rows, double side_m) {
  if (side_m <= 0) return {rows};
  float low[2] = {rows[0], rows[1]}, high[2] = {rows[0], rows[1]};
  for (size_t i = 0; i < rows.size(); i += kRow) {
    for (int axis = 0; axis < 2; ++axis) {
      low[axis] = std::min(low[axis], rows[i + axis]);
      high[axis] = std::max(high[axis], rows[i + axis]);
    }
  }
  const double half_m = 0.5 * side_m;
  std::vector<std::vector<float>> windows;
  for (double y = low[1]; y == low[1] || y + half_m < high[1]; y += half_m) {
    for (double x = low[0]; x == low[0] || x + half_m < high[0]; x += half_m) {
      std::vector<float>& window = windows.emplace_back();
      for (size_t i = 0; i < rows.size(); i += kRow) {
        if (rows[i] < x || rows[i] > x + side_m) continue;
        if (rows[i + 1] < y || rows[i + 1] > y + side_m) continue;
        window.insert(window.end(), rows.begin() + i, rows.begin() + i + kRow);
      }
    }
  }
  return windows;
}

}  // namespace

struct PpfMatcher::Impl {
  PpfMatchOptions options;
  double diameter_m = 0;
  cv::Mat model;
  std::unique_ptr<cv::ppf_match_3d::PPF3DDetector> detector;
};

void PpfMatchOptions::Visit(SettingsVisitor& v) {
  v.Real("model_sampling", model_sampling, {0.001, 1}, "sampling step over the model's extent");
  v.Real("scene_voxel_diameters", scene_voxel_diameters, {1e-4, 10}, "voxel side, diameters");
  v.Real("scene_step", scene_step, {1e-4, 1}, "share of scene points that are reference points");
  v.Real("window_diameters", window_diameters, {0, 1000},
         "side of a window, diameters; 0 = the whole scene");
  v.Real("cluster_m", cluster_m, {0, 10}, "poses nearer than this are averaged, m; 0 = none");
  v.Real("cluster_deg", cluster_deg, {0, 180}, "rotation within which poses are averaged, degrees");
}

void PpfIcpOptions::Visit(SettingsVisitor& v) {
  double tolerance_value = tolerance, rejection_value = rejection;
  v.Integer("iterations", iterations, {1, 10000}, "maximum number of steps per level");
  v.Real("tolerance", tolerance_value, {0, 1}, "change at which the iteration stops");
  v.Real("rejection", rejection_value, {0, 1000}, "limit of a correspondence, in sigmas");
  v.Integer("levels", levels, {1, 20}, "number of resolutions");
  tolerance = static_cast<float>(tolerance_value);
  rejection = static_cast<float>(rejection_value);
}

PpfMatcher::PpfMatcher(const ModelPoints& model, const PpfMatchOptions& options)
    : impl_(std::make_unique<Impl>()) {
  CheckSettings("PpfMatchOptions", options);
  impl_->options = options;
  impl_->diameter_m = model.diameter_m;
  impl_->model = ModelMat(model);
  impl_->detector = std::make_unique<cv::ppf_match_3d::PPF3DDetector>(options.model_sampling);
  impl_->detector->setSearchParams(options.cluster_m, Radians(options.cluster_deg));
  impl_->detector->trainModel(impl_->model);
}

PpfMatcher::~PpfMatcher() = default;

std::vector<float> PpfMatcher::SceneRows(const OrganizedCloud& cloud) const {
  const double voxel_m = impl_->options.scene_voxel_diameters * impl_->diameter_m;
  std::vector<float> rows;
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
    if (taken.insert(key).second) AddRow(p, normal, rows);
  }
  return rows;
}

std::vector<Pose> PpfMatcher::Match(const std::vector<float>& scene_rows) const {
  std::vector<Pose> poses;
  if (scene_rows.size() < kRow * kMinPoints) return poses;
  const PpfMatchOptions& options = impl_->options;
  for (const auto& window : Windows(scene_rows, options.window_diameters * impl_->diameter_m)) {
    if (window.size() < kRow * kMinPoints || !HasVolume(window)) continue;
    std::vector<Pose3DPtr> found;
    impl_->detector->match(ToMat(window), found, options.scene_step,
                           OwnSampling(window, options.scene_voxel_diameters * impl_->diameter_m));
    for (const Pose3DPtr& pose : found) {
      const Pose X_CO = ToPose(pose->pose);
      if (X_CO.matrix().allFinite()) poses.push_back(X_CO);
    }
  }
  return poses;
}

std::vector<Pose> PpfMatcher::Refine(const std::vector<float>& scene_rows,
                                     const std::vector<Pose>& poses,
                                     const PpfIcpOptions& options) const {
  if (poses.empty()) return {};
  std::vector<Pose3DPtr> refined;
  for (const Pose& X_CO : poses) {
    cv::Matx44d m = FromPose(X_CO);
    refined.push_back(cv::makePtr<Pose3D>());
    refined.back()->updatePose(m);
  }
  cv::ppf_match_3d::ICP icp(options.iterations, options.tolerance, options.rejection,
                            options.levels);
  icp.registerModelToScene(impl_->model, ToMat(scene_rows), refined);
  std::vector<Pose> result;
  for (const Pose3DPtr& pose : refined) result.push_back(ToPose(pose->pose));
  return result;
}

}  // namespace pickbed::perception
