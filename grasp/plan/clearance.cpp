#include "grasp/plan/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "grasp/place/boxes_apart.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kRounding_m = 1e-9;  // margin of a search that must not miss a point
constexpr double kMaxColumns = 4e6;   // of a field; 20 m x 20 m of the usual size

// Largest of the distances to the three slabs of the box: negative inside, a lower bound outside.
double SlabDistance(const AxisAlignedBox& box, const Vector3d& p) {
  return ((p - box.center).cwiseAbs() - box.half_size).maxCoeff();
}

struct Interval {
  double low, high;
};

// Heights at which an oriented box can meet the column over a square with this center and half its
// side, both in W from the center of the box; empty (low > high) if it does not. Each pair of faces
// bounds the heights by itself, so the interval may be too large, but never too small. `R_GW` has
// the normals of the faces in its rows.
Interval HeightsOver(const Vector2d& center, double half, const Eigen::Matrix3d& R_GW,
                     const Vector3d& half_size) {
  constexpr double kLevel = 1e-9;  // faces with a smaller slope bound no height
  Interval heights{-std::numeric_limits<double>::infinity(),
                   std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const Eigen::RowVector3d normal = R_GW.row(k);
    const double offset = normal.head<2>().dot(center);
    const double reach = half_size[k] + half * normal.head<2>().cwiseAbs().sum();
    if (std::abs(normal.z()) < kLevel) {
      if (std::abs(offset) > reach + kLevel) return {1, 0};
      continue;
    }
    const double height = -offset / normal.z(), extent = reach / std::abs(normal.z());
    heights.low = std::max(heights.low, height - extent);
    heights.high = std::min(heights.high, height + extent);
  }
  return heights;
}

}  // namespace

std::vector<AxisAlignedBox> HandSweep(const Gripper& gripper, double opening_m) {
  std::vector<AxisAlignedBox> sweep = gripper.Boxes(opening_m);
  for (AxisAlignedBox& box : sweep) {
    box.center.z() -= 0.5 * gripper.approach_m;
    box.half_size.z() += 0.5 * gripper.approach_m;
  }
  return sweep;
}

std::optional<BinContact> FindBinContact(std::span<const AxisAlignedBox> boxes_G, const Pose& X_WG,
                                         std::span<const AxisAlignedBox> bin_boxes,
                                         double clearance_m) {
  for (size_t k = 0; k < bin_boxes.size(); ++k) {
    // Grows along the normals of floor and walls; a tilted hand needs no larger distance.
    AxisAlignedBox grown = bin_boxes[k];
    grown.half_size.array() += clearance_m;
    for (size_t i = 0; i < boxes_G.size(); ++i) {
      if (!BoxesApart(grown, boxes_G[i], X_WG)) {
        return BinContact{static_cast<int>(i), static_cast<int>(k)};
      }
    }
  }
  return std::nullopt;
}

bool HandMeetsBin(const Gripper& gripper, double opening_m, const Pose& X_WG,
                  std::span<const AxisAlignedBox> bin_boxes, double clearance_m) {
  if (FindBinContact(HandSweep(gripper, opening_m), X_WG, bin_boxes, clearance_m)) return true;
  const std::optional<AxisAlignedBox> between = gripper.RegionBetween(opening_m);
  return between && FindBinContact({&*between, 1}, X_WG, bin_boxes, 0);
}

bool AnyInside(const Eigen::Matrix3Xd& points_G, std::span<const AxisAlignedBox> boxes_G) {
  return std::any_of(boxes_G.begin(), boxes_G.end(), [&](const AxisAlignedBox& box) {
    const Eigen::Matrix3Xd outside_m =
        (points_G.colwise() - box.center).cwiseAbs().colwise() - box.half_size;
    return (outside_m.colwise().maxCoeff().array() < 0).any();
  });
}

SurfaceBand::SurfaceBand(const Eigen::Matrix3Xd& points_O, double band_m)
    : corner_(Vector3d::Zero()), size_(Vector3i::Zero()), voxel_m_(0.5 * band_m) {
  if (points_O.cols() == 0) return;
  const double pad = band_m + voxel_m_;
  corner_ = points_O.rowwise().minCoeff().array() - pad;
  const Vector3d top = points_O.rowwise().maxCoeff().array() + pad;
  size_ = ((top - corner_) / voxel_m_).array().ceil().cast<int>() + 1;
  inside_.assign(static_cast<size_t>(size_.x()) * size_.y() * size_.z(), 0);
  for (int i = 0; i < points_O.cols(); ++i) {
    const Vector3d p = (points_O.col(i) - corner_) / voxel_m_;
    const Vector3i home = p.array().floor().cast<int>();
    for (int dx = -2; dx <= 2; ++dx) {
      for (int dy = -2; dy <= 2; ++dy) {
        for (int dz = -2; dz <= 2; ++dz) {
          const Vector3i cell = home + Vector3i(dx, dy, dz);
          const double distance = (cell.cast<double>() + Vector3d::Constant(0.5) - p).norm();
          if (distance <= 2) inside_[Index(cell)] = 1;
        }
      }
    }
  }
}

int SurfaceBand::Index(const Vector3i& cell) const {
  return (cell.z() * size_.y() + cell.y()) * size_.x() + cell.x();
}

bool SurfaceBand::Contains(const Vector3d& p_O) const {
  const Vector3i cell = ((p_O - corner_) / voxel_m_).array().floor().cast<int>();
  if ((cell.array() < 0).any() || (cell.array() >= size_.array()).any()) return false;
  return inside_[Index(cell)] != 0;
}

std::vector<Vector3d> ThinnedCloud(std::span<const Vector3d> cloud_W, const Bin& bin,
                                   double voxel_m, double bin_band_m, double height_m) {
  const Vector3d half(0.5 * bin.inner_size_m.x() + bin.wall_m,
                      0.5 * bin.inner_size_m.y() + bin.wall_m, 0);
  const Vector3d low(-half.x(), -half.y(), -bin.wall_m);
  const Vector3d high(half.x(), half.y(), bin.inner_size_m.z() + height_m);
  const Vector3i size = ((high - low) / voxel_m).array().ceil().cast<int>() + 1;
  std::vector<uint8_t> taken(static_cast<size_t>(size.x()) * size.y() * size.z(), 0);
  const std::vector<AxisAlignedBox> bin_boxes = BinBoxes(bin);

  std::vector<Vector3d> thinned;
  for (const Vector3d& p : cloud_W) {
    // Written so that a point with NaN fails the test.
    if (!((p.array() >= low.array()).all() && (p.array() <= high.array()).all())) continue;
    const Vector3i cell = ((p - low) / voxel_m).cast<int>();
    uint8_t& voxel =
        taken[(static_cast<size_t>(cell.z()) * size.y() + cell.y()) * size.x() + cell.x()];
    if (voxel) continue;
    voxel = 1;
    const bool of_bin = std::any_of(bin_boxes.begin(), bin_boxes.end(), [&](const auto& box) {
      return SlabDistance(box, p) < bin_band_m;
    });
    if (!of_bin) thinned.push_back(p);
  }
  return thinned;
}

ObstacleField::ObstacleField(std::vector<Vector3d> points_W, std::vector<int> groups, double cell_m)
    : corner_(Vector2d::Zero()), cell_m_(cell_m) {
  if (groups.size() != points_W.size() ||
      std::any_of(groups.begin(), groups.end(), [](int group) { return group < 0; })) {
    throw std::logic_error("each obstacle point needs the number of its group, from 0");
  }
  if (!points_W.empty()) {
    Vector2d low = points_W[0].head<2>(), high = low;
    for (const Vector3d& p : points_W) {
      low = low.cwiseMin(p.head<2>());
      high = high.cwiseMax(p.head<2>());
    }
    corner_ = low;
    // A wrong pose can be at any distance. Larger columns need less memory and give equal answers.
    const Vector2d extent_m = high - low;
    while ((extent_m / cell_m_).array().ceil().max(1).prod() > kMaxColumns) cell_m_ *= 2;
    columns_ = static_cast<int>(extent_m.x() / cell_m_) + 1;
    rows_ = static_cast<int>(extent_m.y() / cell_m_) + 1;
  }
  begin_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Vector3d& p : points_W) ++begin_[Column(p.x(), p.y()) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  // Points by column, each sorted from the top down.
  std::vector<int> order(points_W.size());
  std::vector<int> next(begin_.begin(), begin_.end() - 1);
  for (size_t i = 0; i < points_W.size(); ++i) {
    order[next[Column(points_W[i].x(), points_W[i].y())]++] = static_cast<int>(i);
  }
  for (size_t column = 0; column + 1 < begin_.size(); ++column) {
    std::stable_sort(order.begin() + begin_[column], order.begin() + begin_[column + 1],
                     [&](int a, int b) { return points_W[a].z() > points_W[b].z(); });
  }
  for (const int i : order) {
    points_W_.push_back(points_W[i]);
    groups_.push_back(groups[i]);
  }
}

int ObstacleField::Column(double x, double y) const {
  const auto cell = [&](double offset_m, int count) {
    return static_cast<int>(std::clamp(std::floor(offset_m / cell_m_), 0.0, count - 1.0));
  };
  return cell(y - corner_.y(), rows_) * columns_ + cell(x - corner_.x(), columns_);
}

template <typename Visit>
bool ObstacleField::AnyNear(const Pose& X_WG, const AxisAlignedBox& box_G, double margin_m,
                            const std::vector<uint8_t>& ignored, const Visit& visit) const {
  const Vector3d center = X_WG * box_G.center;
  const Vector3d half_size = (box_G.half_size.array() + margin_m).max(0);
  const Vector3d reach = X_WG.linear().cwiseAbs() * half_size;
  const Vector3d low = center - reach, high = center + reach;
  if (!low.allFinite() || !high.allFinite()) return false;  // such a pose meets nothing
  const int first = Column(low.x(), low.y()), last = Column(high.x(), high.y());
  const Eigen::Matrix3d R_GW = X_WG.linear().transpose();
  for (int row = first / columns_; row <= last / columns_; ++row) {
    for (int column = first % columns_; column <= last % columns_; ++column) {
      const Vector2d column_center = corner_ + cell_m_ * Vector2d(column + 0.5, row + 0.5);
      const Interval heights = HeightsOver(column_center - center.head<2>(),
                                           0.5 * cell_m_ + kRounding_m, R_GW, half_size);
      if (heights.low > heights.high) continue;
      const double lowest_m = std::max(low.z(), center.z() + heights.low - kRounding_m);
      const double highest_m = std::min(high.z(), center.z() + heights.high + kRounding_m);
      const auto from = points_W_.begin() + begin_[row * columns_ + column];
      const auto to = points_W_.begin() + begin_[row * columns_ + column + 1];
      const auto start =
          std::partition_point(from, to, [&](const Vector3d& p) { return p.z() > highest_m; });
      const int end = static_cast<int>(to - points_W_.begin());
      for (int i = static_cast<int>(start - points_W_.begin()); i < end; ++i) {
        const Vector3d& p = points_W_[i];
        if (p.z() < lowest_m) break;
        if (ignored[groups_[i]] || (p.array() < low.array()).any() ||
            (p.array() > high.array()).any()) {
          continue;
        }
        if (visit(R_GW * (p - X_WG.translation()))) return true;
      }
    }
  }
  return false;
}

ObstacleField::Answer ObstacleField::Query(const Pose& X_WG,
                                           std::span<const AxisAlignedBox> sweep_G,
                                           const std::optional<AxisAlignedBox>& between_box,
                                           const std::vector<uint8_t>& ignored,
                                           double limit_m) const {
  Answer answer;
  answer.distance_m.assign(sweep_G.size(), limit_m);
  for (size_t k = 0; k < sweep_G.size(); ++k) {
    double& nearest_m = answer.distance_m[k];
    AnyNear(X_WG, sweep_G[k], limit_m, ignored, [&](const Vector3d& p_G) {
      nearest_m = std::min(nearest_m, SlabDistance(sweep_G[k], p_G));
      return false;
    });
  }
  if (!between_box) return answer;
  AnyNear(X_WG, *between_box, 0, ignored, [&](const Vector3d& p_G) {
    answer.between += SlabDistance(*between_box, p_G) < 0;
    return false;
  });
  return answer;
}

std::optional<int> ObstacleField::FirstMet(const Pose& X_WG,
                                           std::span<const AxisAlignedBox> sweep_G,
                                           const std::vector<uint8_t>& ignored,
                                           double clearance_m) const {
  for (size_t k = 0; k < sweep_G.size(); ++k) {
    const bool met = AnyNear(X_WG, sweep_G[k], clearance_m, ignored, [&](const Vector3d& p_G) {
      return SlabDistance(sweep_G[k], p_G) < clearance_m;
    });
    if (met) return static_cast<int>(k);
  }
  return std::nullopt;
}

double ObstacleField::CoveredShare(const Eigen::Matrix3Xd& surface_W,
                                   const std::vector<uint8_t>& ignored, double above_m) const {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::vector<double> top(begin_.size() - 1, kNone);
  std::vector<int> plan;
  for (int i = 0; i < surface_W.cols(); ++i) {
    const Vector2d p = surface_W.col(i).head<2>() - corner_;
    if (p.minCoeff() < 0 || p.x() >= columns_ * cell_m_ || p.y() >= rows_ * cell_m_) continue;
    const int column = Column(surface_W(0, i), surface_W(1, i));
    if (top[column] == kNone) plan.push_back(column);
    top[column] = std::max(top[column], surface_W(2, i));
  }
  if (plan.empty()) return 0;
  int covered = 0;
  for (const int column : plan) {
    for (int i = begin_[column]; i < begin_[column + 1]; ++i) {
      if (!ignored[groups_[i]] && points_W_[i].z() > top[column] + above_m) {
        ++covered;
        break;
      }
    }
  }
  return static_cast<double>(covered) / plan.size();
}

}  // namespace pickbed::grasp
