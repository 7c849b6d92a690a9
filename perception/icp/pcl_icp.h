#pragma once

// Point-to-plane ICP of PCL with the nearest points of the frame as correspondences, for poses that
// are nearly right. It never lowers the quality of a pose.

#include <memory>

#include "perception/cloud/organized_cloud.h"
#include "perception/icp/icp_result.h"
#include "perception/model/model_points.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct PclIcpOptions {
  double max_correspondence_distance_m = 0.005;
  int iterations = 15;
  int max_points = 300;      // the first of the visible model points are used
  int target_stride = 2;     // only every target_stride-th row and column of the frame is searched
  double epsilon_m2 = 1e-9;  // squared shift of a step at which the iteration stops
  void Visit(SettingsVisitor& v);
};

// ICP with the search tree of one frame, shared by all poses. `cloud` must outlive it.
class PclIcp {
 public:
  explicit PclIcp(const OrganizedCloud& cloud, const PclIcpOptions& options = {});
  ~PclIcp();
  PclIcp(PclIcp&&) noexcept;

  // Aligns the visible model points to the frame. The agreement is computed from MeasureFit():
  // inliers, reduced by their residual, minus violations. The result is the start pose if the
  // agreement would decrease (kWorse), or if fewer than six points have a correspondence
  // (kTooFewCorrespondences). Inliers, residual and reciprocal condition number come from
  // ProjectiveIcp at the resulting pose, because PCL does not expose its normal equations.
  IcpResult Refine(const ModelPoints& model, const Pose& X_CO) const;

 private:
  IcpResult Align(const ModelPoints& model, const Pose& X_CO) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::perception
