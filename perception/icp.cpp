#include "perception/icp.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>

#include "perception/projective_icp.h"
#include "perception/verify.h"

namespace pickbed {
namespace {

using Cloud = pcl::PointCloud<pcl::PointNormal>;
using Icp = pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal>;
using SearchTree = pcl::search::KdTree<pcl::PointNormal>;

constexpr size_t kMinPoints = 6;  // as many as unknowns

pcl::PointNormal ToPcl(const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
  pcl::PointNormal point;
  point.getVector3fMap() = p;
  point.getNormalVector3fMap() = n;
  return point;
}

Cloud::Ptr TargetCloud(const OrganizedCloud& cloud, int stride) {
  const Cloud::Ptr target(new Cloud);
  const int width = cloud.intrinsics.width;
  for (const int pixel : cloud.foreground_pixels) {
    if ((pixel % width) % stride != 0 || (pixel / width) % stride != 0) continue;
    const Eigen::Vector3f& normal = cloud.normals_C[pixel];
    if (!normal.isZero(0)) target->push_back(ToPcl(cloud.points_C[pixel], normal));
  }
  return target;
}

// The visible model points where the pose puts them.
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

// What refinement must not lower: inliers, less those that are far off their plane, less points
// where the camera looks through the model.
double Quality(const FitReport& fit) {
  const double miss = fit.residual_m / VerifyBands{}.inlier_m;
  return fit.inlier_share * (1 - miss * miss) - fit.violated_share;
}

// PCL keeps its normal equations to itself; those of the projective ICP hold the same pose.
double ConditioningAt(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO) {
  ProjectiveIcpOptions look;
  look.coarse_iterations = 0;
  look.fine_iterations = 0;
  return ProjectiveIcp(cloud, model, X_CO, look).conditioning;
}

}  // namespace

struct PclRefiner::Impl {
  const OrganizedCloud& cloud;
  PclIcpOptions options;
  Cloud::Ptr target;
  SearchTree::Ptr tree;
};

PclRefiner::PclRefiner(const OrganizedCloud& cloud, const PclIcpOptions& options) {
  // PCL prints when too few points correspond; that is an expected end here.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  impl_ = std::make_unique<Impl>(Impl{cloud, options, nullptr, nullptr});
  impl_->target = TargetCloud(cloud, std::max(1, options.target_stride));
  impl_->tree.reset(new SearchTree);
  if (!impl_->target->empty()) impl_->tree->setInputCloud(impl_->target);
}

PclRefiner::~PclRefiner() = default;
PclRefiner::PclRefiner(PclRefiner&&) noexcept = default;

void PclRefiner::Refine(const ModelPoints& model, PoseHypothesis& hypothesis) const {
  Align(model, hypothesis);
  hypothesis.fit.conditioning = ConditioningAt(impl_->cloud, model, hypothesis.X_CO);
}

void PclRefiner::Align(const ModelPoints& model, PoseHypothesis& hypothesis) const {
  const PclIcpOptions& options = impl_->options;
  const FitReport before = MeasureFit(impl_->cloud, model, hypothesis.X_CO);
  hypothesis.fit = before;
  hypothesis.fit.refinement_kept = false;
  const Cloud::Ptr source = SourceCloud(model, hypothesis.X_CO, options.max_points);
  if (source->size() < kMinPoints || impl_->target->size() < kMinPoints) return;

  Icp icp;
  icp.setSearchMethodTarget(impl_->tree, /*force_no_recompute=*/true);
  icp.setInputTarget(impl_->target);
  icp.setInputSource(source);
  icp.setMaxCorrespondenceDistance(options.max_correspondence_m);
  icp.setMaximumIterations(options.iterations);
  icp.setTransformationEpsilon(options.epsilon_m2);
  Cloud aligned;
  icp.align(aligned);
  const Eigen::Matrix4d step = icp.getFinalTransformation().cast<double>();
  if (!icp.hasConverged() || !step.allFinite()) return;

  Pose X_step = Pose::Identity();
  X_step.linear() = Orthonormalized(step.topLeftCorner<3, 3>());
  X_step.translation() = step.topRightCorner<3, 1>();
  const Pose X_CO = X_step * hypothesis.X_CO;
  const FitReport after = MeasureFit(impl_->cloud, model, X_CO);
  if (Quality(after) < Quality(before)) return;
  hypothesis.unrefined_X_CO = hypothesis.X_CO;
  hypothesis.X_CO = X_CO;
  hypothesis.fit = after;
  hypothesis.fit.refinement_kept = true;
}

}  // namespace pickbed
