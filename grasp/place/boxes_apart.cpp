#include "grasp/place/boxes_apart.h"

#include <cmath>

namespace pickbed::grasp {

bool BoxesApart(const AxisAlignedBox& box_W, const AxisAlignedBox& box_G, const Pose& X_WG) {
  const Eigen::Matrix3d R = X_WG.linear();
  const Eigen::Matrix3d abs_R = R.cwiseAbs();
  const Eigen::Vector3d t = X_WG * box_G.center - box_W.center;
  const Eigen::Vector3d a = box_W.half_size;
  const Eigen::Vector3d b = box_G.half_size;
  if (((t.cwiseAbs() - a - abs_R * b).array() > 0).any()) return true;
  const Eigen::Vector3d t_G = R.transpose() * t;
  if (((t_G.cwiseAbs() - b - abs_R.transpose() * a).array() > 0).any()) return true;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double distance = std::abs(t[i2] * R(i1, j) - t[i1] * R(i2, j));
      const double reach =
          a[i1] * abs_R(i2, j) + a[i2] * abs_R(i1, j) + b[j1] * abs_R(i, j2) + b[j2] * abs_R(i, j1);
      if (distance > reach) return true;
    }
  }
  return false;
}

}  // namespace pickbed::grasp
