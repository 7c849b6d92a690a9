#include "grasp/plan/lift_clearance.h"

#include <algorithm>

namespace pickbed::grasp {

// The space between the walls is convex, so the vertices of the object are sufficient.
bool LiftMeetsWall(const Bin& bin, const ObjectModel& object, const Pose& X_BO,
                   double clearance_m) {
  const Eigen::Array2d room_m = 0.5 * bin.inner_size_m.head<2>().array() - clearance_m;
  const std::vector<Eigen::Vector3d>& vertices = object.mesh_O.vertices;
  return std::any_of(vertices.begin(), vertices.end(), [&](const Eigen::Vector3d& p_O) {
    const Eigen::Vector3d p_B = X_BO * p_O;
    return p_B.z() < bin.inner_size_m.z() && (p_B.head<2>().array().abs() > room_m).any();
  });
}

}  // namespace pickbed::grasp
