#pragma once

// Point-to-plane ICP with projective association, for hundreds of hypotheses per frame. Each
// visible model point is paired with the pixel that it projects to. If they do not match, it is
// paired with a pixel beside it, at half the maximum correspondence distance. The pair must be
// within this distance and the normals must agree. The distance is small, because with a large one
// the pose slides into clutter. Chen and Medioni 1991; Rusinkiewicz and Levoy 2001.

#include "perception/cloud/organized_cloud.h"
#include "perception/icp/icp_result.h"
#include "perception/model/model_points.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct ProjectiveIcpOptions {
  double max_correspondence_distance_m = 0.010;    // in the first iteration
  double final_correspondence_distance_m = 0.003;  // the same in the last one
  int coarse_iterations = 12;  // the maximum distance decreases linearly to the final one
  int fine_iterations = 4;     // with the final distance
  double min_normal_cos = 0.5;
  int max_points = 150;  // the first of the visible points are used; at most 512
  // Added to the diagonal of the normal equations, as a share of its mean (Levenberg 1944). It
  // slows directions that few points constrain, so that the others converge first. In simulated
  // clutter, 0.05 converges from 95 % of starts with errors of 10 degrees and 5 mm, 0.001 from
  // 85 %. Above 0.1 the result is less accurate.
  double damping = 0.05;
  void Visit(SettingsVisitor& v);
};

// Refines X_CO. Stops early at the last valid pose if fewer than six points have a correspondence
// (kTooFewCorrespondences), or if a step exceeds twice the maximum correspondence distance
// (kStepTooLarge). Inliers and residual are those within the final distance. Throws InputError for
// options out of range.
IcpResult ProjectiveIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                        const ProjectiveIcpOptions& options = {});
// The same for inner loops whose options were checked before. Does not allocate.
IcpResult ProjectiveIcpUnchecked(const OrganizedCloud& cloud, const ModelPoints& model,
                                 const Pose& X_CO, const ProjectiveIcpOptions& options);

}  // namespace pickbed::perception
