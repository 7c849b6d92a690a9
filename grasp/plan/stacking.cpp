#include "grasp/plan/stacking.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace pickbed::grasp {
namespace {

using Eigen::Array2i;

constexpr double kNone = -std::numeric_limits<double>::infinity();

}  // namespace

// Number of cells in which `b` is higher than `a`, minus those in which it is lower.
int InstanceStack::CellsHigher(const TopMap& a, const TopMap& b) {
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

void InstanceStack::Add(const Eigen::Matrix3Xd& surface_W) {
  TopMap& map = maps_.emplace_back();
  if (surface_W.cols() == 0) return;
  const Eigen::Array2Xi cells = (surface_W.topRows<2>().array() / cell_m_).floor().cast<int>();
  map.first = cells.rowwise().minCoeff();
  map.size = cells.rowwise().maxCoeff() - map.first + 1;
  map.top_m.assign(static_cast<size_t>(map.size.prod()), kNone);
  for (int k = 0; k < surface_W.cols(); ++k) {
    const Array2i at = cells.col(k) - map.first;
    double& top_m = map.top_m[static_cast<size_t>(at.y()) * map.size.x() + at.x()];
    top_m = std::max(top_m, surface_W(2, k));
  }
}

std::vector<int> InstanceStack::Above(int instance) const {
  std::vector<int> above;
  for (size_t i = 0; i < maps_.size(); ++i) {
    const bool is_other = static_cast<int>(i) != instance;
    if (is_other && CellsHigher(maps_[instance], maps_[i]) > 0)
      above.push_back(static_cast<int>(i));
  }
  return above;
}

}  // namespace pickbed::grasp
