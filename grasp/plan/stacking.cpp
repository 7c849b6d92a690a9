#include "grasp/plan/stacking.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace pickbed::grasp {
namespace {

using Eigen::Array2i;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNone = -kInfinite;

// An instance rests on another one if its lowest point in a cell is between these heights above the
// other one's top. Sampled points and sloped faces need both margins.
constexpr double kBelowTop_m = 0.004;
constexpr double kAboveTop_m = 0.020;
constexpr int kMinCells = 3;

}  // namespace

template <typename Visit>
void InstanceStack::ForEachCommonCell(const HeightMap& a, const HeightMap& b, const Visit& visit) {
  const Array2i begin = a.first.max(b.first);
  const Array2i end = (a.first + a.size).min(b.first + b.size);
  for (int y = begin.y(); y < end.y(); ++y) {
    for (int x = begin.x(); x < end.x(); ++x) visit(x, y);
  }
}

// Number of cells in which `b` is higher than `a`, minus those in which it is lower.
int InstanceStack::CellsHigher(const HeightMap& a, const HeightMap& b) {
  int higher = 0;
  ForEachCommonCell(a, b, [&](int x, int y) {
    const double top_a_m = a.top_m[a.Index(x, y)], top_b_m = b.top_m[b.Index(x, y)];
    if (top_a_m == kNone || top_b_m == kNone || top_a_m == top_b_m) return;
    higher += top_b_m > top_a_m ? 1 : -1;
  });
  return higher;
}

void InstanceStack::Add(const Eigen::Matrix3Xd& surface_W) {
  HeightMap& map = maps_.emplace_back();
  if (surface_W.cols() == 0) return;
  const Eigen::Array2Xi cells = (surface_W.topRows<2>().array() / cell_m_).floor().cast<int>();
  map.first = cells.rowwise().minCoeff();
  map.size = cells.rowwise().maxCoeff() - map.first + 1;
  map.top_m.assign(static_cast<size_t>(map.size.prod()), kNone);
  map.bottom_m.assign(map.top_m.size(), kInfinite);
  for (int k = 0; k < surface_W.cols(); ++k) {
    const size_t at = map.Index(cells(0, k), cells(1, k));
    map.top_m[at] = std::max(map.top_m[at], surface_W(2, k));
    map.bottom_m[at] = std::min(map.bottom_m[at], surface_W(2, k));
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

std::optional<Eigen::Vector2d> InstanceStack::CenterOfCover(int instance,
                                                            const std::vector<bool>& counts) const {
  const HeightMap& below = maps_[instance];
  Eigen::Vector2d sum_m = Eigen::Vector2d::Zero();
  int cells = 0;
  for (size_t i = 0; i < maps_.size(); ++i) {
    if (static_cast<int>(i) == instance || !counts[i]) continue;
    ForEachCommonCell(below, maps_[i], [&](int x, int y) {
      const double top_m = below.top_m[below.Index(x, y)];
      const double bottom_m = maps_[i].bottom_m[maps_[i].Index(x, y)];
      if (!(bottom_m > top_m - kBelowTop_m && bottom_m < top_m + kAboveTop_m)) return;
      sum_m += cell_m_ * Eigen::Vector2d(x + 0.5, y + 0.5);
      ++cells;
    });
  }
  if (cells < kMinCells) return std::nullopt;
  return sum_m / cells;
}

}  // namespace pickbed::grasp
