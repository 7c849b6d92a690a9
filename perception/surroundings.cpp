#include "perception/surroundings.h"

#include <algorithm>
#include <limits>

namespace pickbed {
namespace {

// A plane of the camera's frame as points of the part see it.
struct PlaneInPart {
  Eigen::Vector3f normal_O = Eigen::Vector3f::Zero();
  float offset_m = 0;

  PlaneInPart(const BackgroundPlane& plane, const Eigen::Isometry3f& X_CO)
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
  const PlaneInPart floor(cloud.planes.back(), X);
  found.has_floor = true;
  found.height_m = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& p_O : model.points_O) {
    found.height_m = std::min(found.height_m, floor.SignedDistance(p_O));
  }
  found.outside_m = std::max(0.0f, -found.height_m);
  for (size_t i = 0; i + 1 < cloud.planes.size(); ++i) {
    const PlaneInPart wall(cloud.planes[i], X);
    if (wall.SignedDistance(model.center_O) > model.radius_m) continue;
    for (const Eigen::Vector3f& p_O : model.points_O) {
      if (floor.SignedDistance(p_O) >= cloud.wall_height_m) continue;
      found.outside_m = std::max(found.outside_m, -wall.SignedDistance(p_O));
    }
  }
  return found;
}

}  // namespace pickbed
