#include "grasp/plan/stacking.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pickbed::grasp {

std::vector<std::vector<int>> InstancesAbove(std::span<const Eigen::Matrix3Xd> surfaces_W,
                                             double cell_m) {
  const int count = static_cast<int>(surfaces_W.size());
  Eigen::AlignedBox2d plan;
  for (const Eigen::Matrix3Xd& points_W : surfaces_W) {
    for (int k = 0; k < points_W.cols(); ++k) plan.extend(points_W.col(k).head<2>());
  }
  if (plan.isEmpty()) return std::vector<std::vector<int>>(count);
  const Eigen::Array2i size = (plan.sizes().array() / cell_m).floor().cast<int>() + 1;

  struct Top {
    int instance;
    double z_m;
  };
  std::vector<std::vector<Top>> tops(static_cast<size_t>(size.prod()));  // by cell
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < surfaces_W[i].cols(); ++k) {
      const Eigen::Vector3d p_W = surfaces_W[i].col(k);
      const Eigen::Array2i cell =
          ((p_W.head<2>() - plan.min()).array() / cell_m).floor().cast<int>().min(size - 1);
      std::vector<Top>& here = tops[static_cast<size_t>(cell.y()) * size.x() + cell.x()];
      if (here.empty() || here.back().instance != i) here.push_back({i, p_W.z()});
      here.back().z_m = std::max(here.back().z_m, p_W.z());
    }
  }

  // Cells in which the column's instance is higher than the row's, minus cells in which it is
  // lower.
  Eigen::MatrixXi higher = Eigen::MatrixXi::Zero(count, count);
  for (const std::vector<Top>& here : tops) {
    for (const Top& a : here) {
      for (const Top& b : here) {
        if (a.z_m != b.z_m) higher(a.instance, b.instance) += b.z_m > a.z_m ? 1 : -1;
      }
    }
  }
  std::vector<std::vector<int>> above(count);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) {
      if (higher(a, b) > 0) above[a].push_back(b);
    }
  }
  return above;
}

}  // namespace pickbed::grasp
