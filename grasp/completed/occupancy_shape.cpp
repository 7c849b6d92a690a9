#include "grasp/completed/occupancy_shape.h"

#include <array>

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Corners of a cube of cell centers; bit k of the number is the step along axis k.
constexpr int kCorners = 8;
Vector3i Corner(int number) { return {number & 1, number >> 1 & 1, number >> 2 & 1}; }

class SurfaceNet {
 public:
  // A cube with index (x, y, z) has its first corner at the cell (x - 1, y - 1, z - 1), so that the
  // surface is closed at the border of the grid.
  SurfaceNet(const OccupancyShape& shape, double level)
      : shape_(shape), level_(level), side_(shape.size + 1) {}

  TriangleMesh Make() {
    vertex_of_.assign(static_cast<size_t>(side_) * side_ * side_, -1);
    ForEachCube([&](const Vector3i& cube) { AddVertex(cube); });
    ForEachCube([&](const Vector3i& cube) {
      for (int axis = 0; axis < 3; ++axis) AddFace(cube, axis);
    });
    return std::move(mesh_);
  }

 private:
  template <typename Visit>
  void ForEachCube(const Visit& visit) {
    for (int z = 0; z < side_; ++z) {
      for (int y = 0; y < side_; ++y) {
        for (int x = 0; x < side_; ++x) visit(Vector3i(x, y, z));
      }
    }
  }

  double At(const Vector3i& cube, int corner) const {
    const Vector3i cell = cube + Corner(corner) - Vector3i::Ones();
    return shape_.At(cell.x(), cell.y(), cell.z());
  }
  bool IsInside(double value) const { return value >= level_; }
  int& VertexOf(const Vector3i& cube) {
    return vertex_of_[(static_cast<size_t>(cube.z()) * side_ + cube.y()) * side_ + cube.x()];
  }

  // The vertex is the mean of the crossings of the edges.
  void AddVertex(const Vector3i& cube) {
    std::array<double, kCorners> values{};
    int inside = 0;
    for (int k = 0; k < kCorners; ++k) {
      values[k] = At(cube, k);
      inside += IsInside(values[k]);
    }
    if (inside == 0 || inside == kCorners) return;
    Vector3d sum = Vector3d::Zero();
    int crossings = 0;
    for (int k = 0; k < kCorners; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        const int other = k | 1 << axis;
        if (other == k || IsInside(values[k]) == IsInside(values[other])) continue;
        Vector3d place = Corner(k).cast<double>();
        place[axis] = (level_ - values[k]) / (values[other] - values[k]);
        sum += place;
        ++crossings;
      }
    }
    VertexOf(cube) = static_cast<int>(mesh_.vertices.size());
    // The first corner is the center of a cell: half a cell less one.
    mesh_.vertices.push_back(shape_.cell_m *
                             (cube.cast<double>() + sum / crossings - Vector3d::Constant(0.5)));
  }

  // The four cubes around the edge that leaves the first corner of `cube` along `axis`.
  void AddFace(const Vector3i& cube, int axis) {
    const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
    if (cube.dot(u) == 0 || cube.dot(v) == 0) return;
    const bool first = IsInside(At(cube, 0)), last = IsInside(At(cube, 1 << axis));
    if (first == last) return;
    // Counter-clockwise as seen from the end of the axis.
    std::array<int, 4> corners{VertexOf(cube - u - v), VertexOf(cube - v), VertexOf(cube),
                               VertexOf(cube - u)};
    if (last) std::swap(corners[1], corners[3]);
    mesh_.triangles.emplace_back(corners[0], corners[1], corners[2]);
    mesh_.triangles.emplace_back(corners[0], corners[2], corners[3]);
  }

  const OccupancyShape& shape_;
  const double level_;
  const int side_;
  std::vector<int> vertex_of_;  // by cube; -1 = none
  TriangleMesh mesh_;
};

}  // namespace

OccupancyShape Smoothed(const OccupancyShape& shape) {
  OccupancyShape result = shape;
  std::vector<float> before;
  const auto size = static_cast<size_t>(shape.size);
  for (const size_t step : {size_t{1}, size, size * size}) {
    before = result.occupancy;
    for (size_t i = 0; i < before.size(); ++i) {
      const size_t place = i / step % size;
      const float low = place > 0 ? before[i - step] : 0;
      const float high = place + 1 < size ? before[i + step] : 0;
      result.occupancy[i] = 0.25f * (low + 2 * before[i] + high);
    }
  }
  return result;
}

TriangleMesh SurfaceOf(const OccupancyShape& shape, double level) {
  return SurfaceNet(shape, level).Make();
}

std::vector<Vector3d> ShellOf(const OccupancyShape& shape, double level) {
  std::vector<Vector3d> points_W;
  for (int z = 0; z < shape.size; ++z) {
    for (int y = 0; y < shape.size; ++y) {
      for (int x = 0; x < shape.size; ++x) {
        if (!(shape.At(x, y, z) > level)) continue;
        const bool is_shell =
            !(shape.At(x - 1, y, z) > level) || !(shape.At(x + 1, y, z) > level) ||
            !(shape.At(x, y - 1, z) > level) || !(shape.At(x, y + 1, z) > level) ||
            !(shape.At(x, y, z - 1) > level) || !(shape.At(x, y, z + 1) > level);
        if (is_shell) points_W.push_back(shape.X_WV * shape.Center_V(x, y, z));
      }
    }
  }
  return points_W;
}

}  // namespace pickbed::grasp
