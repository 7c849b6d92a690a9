#include "grasp/plan/stacking.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace pickbed::grasp {
namespace {

using Eigen::Array2i;

constexpr double kNone = -std::numeric_limits<double>::infinity();

// The cells of the floor plan around one instance, with the height of its top in each.
struct TopMap {
  Array2i first = Array2i::Zero();  // the cell with the smallest indices
  Array2i size = Array2i::Zero();
  std::vector<double> top_m;  // by row, then column; kNone outside the instance

  double Top_m(int x, int y) const {
    return top_m[static_cast<size_t>(y - first.y()) * size.x() + (x - first.x())];
  }
};

TopMap MakeTopMap(const Eigen::Matrix3Xd& surface_W, double cell_m) {
  TopMap map;
  if (surface_W.cols() == 0) return map;
  const Eigen::Array2Xi cells = (surface_W.topRows<2>().array() / cell_m).floor().cast<int>();
  map.first = cells.rowwise().minCoeff();
  map.size = cells.rowwise().maxCoeff() - map.first + 1;
  map.top_m.assign(static_cast<size_t>(map.size.prod()), kNone);
  for (int k = 0; k < surface_W.cols(); ++k) {
    const Array2i at = cells.col(k) - map.first;
    double& top_m = map.top_m[static_cast<size_t>(at.y()) * map.size.x() + at.x()];
    top_m = std::max(top_m, surface_W(2, k));
  }
  return map;
}

// Number of cells in which `b` is higher than `a`, minus those in which it is lower.
int CellsHigher(const TopMap& a, const TopMap& b) {
  const Array2i begin = a.first.max(b.first);
  const Array2i end = (a.first + a.size).min(b.first + b.size);
  int higher = 0;
  for (int y = begin.y(); y < end.y(); ++y) {
    for (int x = begin.x(); x < end.x(); ++x) {
      const double top_a_m = a.Top_m(x, y), top_b_m = b.Top_m(x, y);
      if (top_a_m == kNone || top_b_m == kNone || top_a_m == top_b_m) continue;
      higher += top_b_m > top_a_m ? 1 : -1;
    }
  }
  return higher;
}

}  // namespace

std::vector<std::vector<int>> InstancesAbove(std::span<const Eigen::Matrix3Xd> surfaces_W,
                                             double cell_m) {
  std::vector<TopMap> maps;
  for (const Eigen::Matrix3Xd& surface_W : surfaces_W) {
    maps.push_back(MakeTopMap(surface_W, cell_m));
  }
  const int count = static_cast<int>(maps.size());
  std::vector<std::vector<int>> above(count);
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const int higher = CellsHigher(maps[a], maps[b]);
      if (higher > 0) above[a].push_back(b);
      if (higher < 0) above[b].push_back(a);
    }
  }
  return above;
}

}  // namespace pickbed::grasp
