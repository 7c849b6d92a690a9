#include "grasp/plan/lift_aside.h"

#include <algorithm>

namespace pickbed::grasp {
namespace {

using Eigen::Vector2d;

constexpr double kMinLever_m = 0.003;
constexpr double kWallClearance_m = 0.01;

}  // namespace

Vector2d AwayFrom(const Vector2d& cover, const Vector2d& center_of_mass, double length_m) {
  const Vector2d away_m = center_of_mass - cover;
  if (away_m.norm() < kMinLever_m) return Vector2d::Zero();
  return length_m * away_m.normalized();
}

Vector2d ShiftInBin(const Vector2d& shift_m, const Bin& bin, const Eigen::Matrix3Xd& target_B,
                    std::span<const AxisAlignedBox> boxes_G, const Pose& X_BG) {
  if (shift_m.isZero() || bin.inner_size_m.z() <= 0) return shift_m;  // a table has no walls
  Vector2d reach_m = Vector2d::Zero();  // towards the wall that the shift approaches
  for (int axis = 0; axis < 2; ++axis) {
    const double side = shift_m[axis] < 0 ? -1 : 1;
    for (int i = 0; i < target_B.cols(); ++i) {
      if (target_B(2, i) > bin.inner_size_m.z()) continue;
      reach_m[axis] = std::max(reach_m[axis], side * target_B(axis, i));
    }
    for (const AxisAlignedBox& box : boxes_G) {
      const Eigen::Vector3d center_B = X_BG * box.center;
      const Eigen::Vector3d half_B = X_BG.linear().cwiseAbs() * box.half_size;
      if (center_B.z() - half_B.z() > bin.inner_size_m.z()) continue;
      reach_m[axis] = std::max(reach_m[axis], side * center_B[axis] + half_B[axis]);
    }
  }
  const Vector2d room_m = (0.5 * bin.inner_size_m.head<2>() - reach_m).array() - kWallClearance_m;
  return shift_m.cwiseAbs().cwiseMin(room_m.cwiseMax(0)).cwiseProduct(shift_m.cwiseSign());
}

}  // namespace pickbed::grasp
