#include "perception/icp/pcl_icp.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>

#include "perception/icp/normal_equations.h"
#include "perception/icp/projective_icp.h"
#include "perception/verify/pose_features.h"

namespace pickbed::perception {
namespace {

using Cloud = pcl::PointCloud<pcl::PointNormal>;

// Point-to-plane steps of PCL. The equations are singular where the points can slide, for example
// on one plane. Their solution is then infinite or not a number, and PCL's search aborts the
// program at such a point. Steps that are not finite or move the points further than
// correspondences can be valid are replaced by no step, which ends the iteration.
class BoundedStep
    : public pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal,
                                                                        pcl::PointNormal> {
 public:
  using Base = pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal,
                                                                          pcl::PointNormal>;

  explicit BoundedStep(float max_step_m) : max_step_m_(max_step_m) {}

  using Base::estimateRigidTransformation;
  void estimateRigidTransformation(const Cloud& source, const Cloud& target,
                                   const pcl::Correspondences& correspondences,
                                   Matrix4& step) const override {
    Base::estimateRigidTransformation(source, target, correspondences, step);
    has_failed_ = !IsBounded(source, correspondences, step);
    if (has_failed_) step.setIdentity();
  }

  // Whether the last step was replaced.
  bool has_failed() const { return has_failed_; }

 private:
  bool IsBounded(const Cloud& source, const pcl::Correspondences& correspondences,
                 const Matrix4& step) const {
    return std::all_of(correspondences.begin(), correspondences.end(), [&](const auto& pair) {
      const Eigen::Vector3f p = source[pair.index_query].getVector3fMap();
      const Eigen::Vector3f moved = step.topLeftCorner<3, 3>() * p + step.topRightCorner<3, 1>();
      return (moved - p).norm() <= max_step_m_;  // false for NaN
    });
  }

  float max_step_m_;
  mutable bool has_failed_ = false;
};

// PCL keeps the number of iterations in a protected member.
class Icp : public pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> {
 public:
  int iterations() const { return nr_iterations_; }
};

using SearchTree = pcl::search::KdTree<pcl::PointNormal>;

constexpr size_t kMinPoints = kMinIcpPairs;
constexpr double kMaxStepDiameters = 1;  // movement of a point in one step

pcl::PointNormal ToPcl(const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
  pcl::PointNormal point;
  point.getVector3fMap() = p;
  point.getNormalVector3fMap() = n;
  return point;
}

Cloud::Ptr TargetCloud(const OrganizedCloud& cloud, int stride) {
  const Cloud::Ptr target(new Cloud);
  const int width = cloud.intrinsics.width();
  for (const int pixel : cloud.foreground_pixels) {
    if ((pixel % width) % stride != 0 || (pixel / width) % stride != 0) continue;
    const Eigen::Vector3f& normal = cloud.normals_C[pixel];
    if (!normal.isZero(0)) target->push_back(ToPcl(cloud.points_C[pixel], normal));
  }
  return target;
}

// The visible model points at the pose, in the camera frame.
Cloud::Ptr SourceCloud(const ModelPoints& model, const Pose& X_CO, int max_points) {
  const Cloud::Ptr source(new Cloud);
  const Eigen::Isometry3f X = X_CO.cast<float>();
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  const int count = std::min(static_cast<int>(visible.size()), max_points);
  for (int i = 0; i < count; ++i) {
    const int index = visible[i];
    source->push_back(ToPcl(X * model.points_O[index], X.linear() * model.normals_O[index]));
  }
  return source;
}

// Quality that refinement must not lower: inlier share, reduced by the residual, minus the share of
// violated points.
double Quality(const FitReport& fit) {
  const double miss = fit.residual_m / VerifyBands{}.inlier_m;
  return fit.inlier_share * (1 - miss * miss) - fit.violated_share;
}

// Inliers, residual and condition at a pose. It is not changed.
IcpResult EvaluateAt(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO) {
  ProjectiveIcpOptions evaluate_only;
  evaluate_only.coarse_iterations = 0;
  evaluate_only.fine_iterations = 0;
  return ProjectiveIcpUnchecked(cloud, model, X_CO, evaluate_only);
}

}  // namespace

struct PclIcp::Impl {
  const OrganizedCloud& cloud;
  PclIcpOptions options;
  Cloud::Ptr target;
  SearchTree::Ptr tree;
};

void PclIcpOptions::Visit(SettingsVisitor& v) {
  v.Real("max_correspondence_distance_m", max_correspondence_distance_m, {1e-5, 1},
         "maximum distance of a correspondence, m");
  v.Integer("iterations", iterations, {0, 10000}, "maximum number of steps");
  v.Integer("max_points", max_points, {6, 100000}, "maximum number of model points");
  v.Integer("target_stride", target_stride, {1, 1000}, "rows and columns per searched one");
  v.Real("epsilon_m2", epsilon_m2, {0, 1}, "squared shift at which the iteration stops, m^2");
}

PclIcp::PclIcp(const OrganizedCloud& cloud, const PclIcpOptions& options) {
  CheckSettings("PclIcpOptions", options);
  // PCL prints an error if too few points correspond, which is an expected result here.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  impl_ = std::make_unique<Impl>(Impl{cloud, options, nullptr, nullptr});
  impl_->target = TargetCloud(cloud, std::max(1, options.target_stride));
  impl_->tree.reset(new SearchTree);
  if (!impl_->target->empty()) impl_->tree->setInputCloud(impl_->target);
}

PclIcp::~PclIcp() = default;
PclIcp::PclIcp(PclIcp&&) noexcept = default;

IcpResult PclIcp::Refine(const ModelPoints& model, const Pose& X_CO) const {
  IcpResult result = Align(model, X_CO);
  const IcpResult at_result = EvaluateAt(impl_->cloud, model, result.X_CO);
  result.inlier_fraction = at_result.inlier_fraction;
  result.rmse_m = at_result.rmse_m;
  result.reciprocal_condition_number = at_result.reciprocal_condition_number;
  return result;
}

IcpResult PclIcp::Align(const ModelPoints& model, const Pose& X_CO) const {
  const PclIcpOptions& options = impl_->options;
  IcpResult result;
  result.X_CO = X_CO;
  result.start_agreement = result.agreement = Quality(MeasureFit(impl_->cloud, model, X_CO));
  const Cloud::Ptr source = SourceCloud(model, X_CO, options.max_points);
  if (source->size() < kMinPoints || impl_->target->size() < kMinPoints) return result;

  Icp icp;
  const auto steps =
      pcl::make_shared<BoundedStep>(static_cast<float>(kMaxStepDiameters * model.diameter_m));
  icp.setTransformationEstimation(steps);
  icp.setSearchMethodTarget(impl_->tree, /*force_no_recompute=*/true);
  icp.setInputTarget(impl_->target);
  icp.setInputSource(source);
  icp.setMaxCorrespondenceDistance(impl_->cloud.error_scale *
                                   options.max_correspondence_distance_m);
  icp.setMaximumIterations(options.iterations);
  icp.setTransformationEpsilon(options.epsilon_m2);
  Cloud aligned;
  icp.align(aligned);
  if (!icp.hasConverged()) return result;
  result.status = IcpStatus::kStepTooLarge;
  if (steps->has_failed()) return result;
  const Eigen::Matrix4d step = icp.getFinalTransformation().cast<double>();

  Pose X_step = Pose::Identity();
  X_step.linear() = Orthonormalized(step.topLeftCorner<3, 3>());
  X_step.translation() = step.topRightCorner<3, 1>();
  const Pose refined_X_CO = X_step * X_CO;
  const double agreement = Quality(MeasureFit(impl_->cloud, model, refined_X_CO));
  result.status = IcpStatus::kWorse;
  if (agreement < result.start_agreement) return result;
  result.status = IcpStatus::kRefined;
  result.X_CO = refined_X_CO;
  result.agreement = agreement;
  result.iterations = icp.iterations();
  return result;
}

}  // namespace pickbed::perception
