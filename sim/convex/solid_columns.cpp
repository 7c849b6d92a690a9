#include "sim/convex/solid_columns.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace pickbed::sim {
namespace {

// Offset of the columns in their cells, as a share of a cell. It is irrational, so that columns
// miss the edges of objects drawn on a grid.
constexpr double kOffset = 0.41421356237;

struct Hit {
  double z_m;
  int sign;  // sign of the triangle normal's z
};

// Returns where the line through (x, y) along z meets a triangle. A shared edge belongs to one of
// its two triangles only, by the sign rule of half-open intervals.
std::optional<Hit> LineHit(const TriangleMesh& mesh, const Eigen::Vector3i& t, double x, double y) {
  std::array<Eigen::Vector3d, 3> p{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  bool inside = false;  // crossing parity in the plane
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d *low = &p[i], *high = &p[(i + 1) % 3];
    if ((low->y() > y) == (high->y() > y)) continue;
    // Both triangles of the edge must round alike.
    if (low->y() > high->y()) std::swap(low, high);
    const double along = (high->x() - low->x()) * (y - low->y()) / (high->y() - low->y());
    if (x < along + low->x()) inside = !inside;
  }
  if (!inside) return std::nullopt;
  const Eigen::Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]);
  if (n.z() == 0) return std::nullopt;
  const double z_m = p[0].z() - (n.x() * (x - p[0].x()) + n.y() * (y - p[0].y())) / n.z();
  return Hit{z_m, n.z() > 0 ? 1 : -1};
}

}  // namespace

SolidColumns::SolidColumns(const TriangleMesh& mesh, int resolution) {
  const Bounds bounds = MeshBounds(mesh);
  low_x_m_ = bounds.min.x();
  low_y_m_ = bounds.min.y();
  cell_m_ = std::max(bounds.size().x(), bounds.size().y()) / resolution;
  if (!(cell_m_ > 0)) return;  // no column crosses a point or a line along z
  columns_x_ = static_cast<int>(bounds.size().x() / cell_m_) + 1;
  columns_y_ = static_cast<int>(bounds.size().y() / cell_m_) + 1;
  columns_.resize(static_cast<size_t>(columns_x_) * columns_y_);
  const auto column_at = [&](double along, int count) {
    return std::clamp(static_cast<int>(along / cell_m_), 0, count - 1);
  };
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Eigen::AlignedBox3d box;
    for (const int v : t) box.extend(mesh.vertices[v]);
    const int last_x = column_at(box.max().x() - low_x_m_, columns_x_);
    const int last_y = column_at(box.max().y() - low_y_m_, columns_y_);
    for (int j = column_at(box.min().y() - low_y_m_, columns_y_); j <= last_y; ++j) {
      for (int i = column_at(box.min().x() - low_x_m_, columns_x_); i <= last_x; ++i) {
        const double x = low_x_m_ + (i + kOffset) * cell_m_, y = low_y_m_ + (j + kOffset) * cell_m_;
        const std::optional<Hit> hit = LineHit(mesh, t, x, y);
        if (hit) columns_[static_cast<size_t>(j) * columns_x_ + i].push_back({hit->z_m, hit->sign});
      }
    }
  }
  if (VolumeIn({bounds.min, bounds.max}) < 0) orientation_ = -1;
}

double SolidColumns::VolumeIn(const Eigen::AlignedBox3d& box) const {
  const auto overlap = [&](double low, double high, double from) {
    return std::max(0.0, std::min(high, from + cell_m_) - std::max(low, from));
  };
  double volume_m3 = 0;
  for (int j = 0; j < columns_y_; ++j) {
    const double dy_m = overlap(box.min().y(), box.max().y(), low_y_m_ + j * cell_m_);
    if (dy_m == 0) continue;
    for (int i = 0; i < columns_x_; ++i) {
      const double dx_m = overlap(box.min().x(), box.max().x(), low_x_m_ + i * cell_m_);
      if (dx_m == 0) continue;
      double length_m = 0;
      for (const Crossing& crossing : columns_[static_cast<size_t>(j) * columns_x_ + i]) {
        length_m += crossing.sign * std::clamp(crossing.z_m, box.min().z(), box.max().z());
      }
      volume_m3 += length_m * dx_m * dy_m;
    }
  }
  return orientation_ * volume_m3;
}

bool IsInside(const TriangleMesh& mesh, const Eigen::Vector3d& point) {
  int above = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const std::optional<Hit> hit = LineHit(mesh, t, point.x(), point.y());
    if (hit && hit->z_m > point.z()) ++above;
  }
  return above % 2 == 1;
}

}  // namespace pickbed::sim
