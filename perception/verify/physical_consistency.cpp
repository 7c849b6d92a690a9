#include "perception/verify/physical_consistency.h"

#include <algorithm>
#include <limits>

namespace pickbed::perception {
namespace {

// A background plane in the object frame.
struct PlaneInObject {
  Eigen::Vector3f normal_O = Eigen::Vector3f::Zero();
  float offset_m = 0;

  PlaneInObject(const BackgroundPlane& plane, const Eigen::Isometry3f& X_CO)
      : normal_O(X_CO.linear().transpose() * plane.normal_C),
        offset_m(plane.offset_m - plane.normal_C.dot(X_CO.translation())) {}
  float SignedDistance(const Eigen::Vector3f& p_O) const { return normal_O.dot(p_O) - offset_m; }
};

}  // namespace

Containment MeasureContainment(const OrganizedCloud& cloud, const ModelPoints& model,
                               const Pose& X_CO) {
  Containment found;
  if (cloud.planes.empty()) return found;
  const Eigen::Isometry3f X = X_CO.cast<float>();
  const PlaneInObject floor(cloud.planes.back(), X);
  found.has_floor = true;
  found.height_m = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& p_O : model.points_O) {
    found.height_m = std::min(found.height_m, floor.SignedDistance(p_O));
  }
  found.outside_m = std::max(0.0f, -found.height_m);
  for (size_t i = 0; i + 1 < cloud.planes.size(); ++i) {
    const PlaneInObject wall(cloud.planes[i], X);
    if (wall.SignedDistance(model.center_O) > model.radius_m) continue;
    for (const Eigen::Vector3f& p_O : model.points_O) {
      if (floor.SignedDistance(p_O) >= cloud.wall_height_m) continue;
      found.outside_m = std::max(found.outside_m, -wall.SignedDistance(p_O));
    }
  }
  return found;
}

namespace {

constexpr size_t kPoints = 400;  // the first points of a model already cover it evenly

// Maximum depth of the points of a inside b.
float DepthIn(const ModelPoints& a, const ModelPoints& b, const Eigen::Isometry3f& X_ba) {
  const float max_squared_m2 = b.radius_m * b.radius_m;  // no point outside the ball is inside b
  float deepest_m = 0;
  const size_t count = std::min(kPoints, a.points_O.size());
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f p_b = X_ba * a.points_O[i];
    if ((p_b - b.center_O).squaredNorm() > max_squared_m2) continue;
    deepest_m = std::max(deepest_m, b.distance.DepthAt(p_b));
  }
  return deepest_m;
}

}  // namespace

double PenetrationDepth(const ModelPoints& a, const Pose& X_Ca, const ModelPoints& b,
                        const Pose& X_Cb) {
  const Eigen::Vector3d between =
      X_Ca * a.center_O.cast<double>() - X_Cb * b.center_O.cast<double>();
  if (between.norm() > a.radius_m + b.radius_m) return 0;
  const Eigen::Isometry3f X_ba = (X_Cb.inverse(Eigen::Isometry) * X_Ca).cast<float>();
  return std::max(DepthIn(a, b, X_ba), DepthIn(b, a, X_ba.inverse(Eigen::Isometry)));
}

}  // namespace pickbed::perception
