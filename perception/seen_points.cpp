#include "perception/seen_points.h"

#include <algorithm>
#include <cmath>

#include "perception/projector.h"

namespace pickbed {

std::vector<SeenPoint> SeenPoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                  const Pose& X_CO) {
  constexpr size_t kMaxPoints = 400;
  constexpr float kSeen_m = 0.004f;       // of a point and its reading, along the normal, at 1 m
  constexpr float kMinFacingCos = 0.35f;  // beyond it a pixel sees much of the surface
  const Projector project(cloud.intrinsics);
  const Eigen::Isometry3f X = X_CO.cast<float>();
  const float z_m = (X * model.center_O).z();
  const float seen_m = kSeen_m * std::max(1.0f, z_m * z_m);
  std::vector<SeenPoint> seen;
  for (const uint16_t index : model.VisibleFrom(X_CO)) {
    if (seen.size() == kMaxPoints) break;
    const Eigen::Vector3f p = X * model.points_O[index];
    const Eigen::Vector3f n = X.linear() * model.normals_O[index];
    if (-n.dot(p.normalized()) < kMinFacingCos) continue;
    const int pixel = project(p);
    if (pixel < 0 || !(cloud.depth_m.data()[pixel] > 0)) continue;
    if (std::abs(n.dot(cloud.points_C[pixel] - p)) > seen_m) continue;
    seen.push_back({index, pixel});
  }
  return seen;
}

}  // namespace pickbed
