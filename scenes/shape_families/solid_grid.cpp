#include "scenes/shape_families/solid_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr int kBlockPoints = 8;       // along each axis
constexpr int kBisections = 14;       // 1e-4 of a cell
constexpr float kNormalStep = 0.02f;  // cells
// Grid planes are shifted by these shares of a cell, so that flat sides are not on them.
const Vector3f kShift(2.37f, 2.41f, 2.43f);
constexpr double kMaxPoints = 1e9;  // they have indices of 32 bits
constexpr int kMargin = 5;          // points beyond the box along each axis, both sides together

void FillBlock(const SolidShape& solid, const Vector3i& first, SolidGrid& grid) {
  const Vector3i last = (first + Vector3i::Constant(kBlockPoints)).cwiseMin(grid.size);
  const Vector3f half = 0.5f * grid.cell_m * (last - first).cast<float>();
  const Vector3f low = grid.origin_O + grid.cell_m * first.cast<float>();
  // One more cell around the points, so that no edge of them crosses the surface.
  const float reach = half.norm() + 2 * grid.cell_m;
  const float center = solid.SignedDistance_m(low + half);
  std::vector<Vector3f> points;
  std::vector<float> distances;
  if (std::abs(center) <= reach) {
    for (int z = first.z(); z < last.z(); ++z) {
      for (int y = first.y(); y < last.y(); ++y) {
        for (int x = first.x(); x < last.x(); ++x) {
          points.push_back(grid.origin_O + grid.cell_m * Vector3i(x, y, z).cast<float>());
        }
      }
    }
    distances.resize(points.size());
    solid.SignedDistances_m(points, distances);
  }
  size_t next = 0;
  for (int z = first.z(); z < last.z(); ++z) {
    for (int y = first.y(); y < last.y(); ++y) {
      for (int x = first.x(); x < last.x(); ++x) {
        grid.inside[grid.Index(x, y, z)] = (points.empty() ? center : distances[next++]) <= 0;
      }
    }
  }
}

void FindCrossings(const SolidShape& solid, SolidGrid& grid) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int index = 0; index + grid.stride(axis) < static_cast<int>(grid.inside.size()); ++index) {
      // The outermost points are outside, so an edge never wraps around to the next row.
      const bool from = grid.inside[index], to = grid.inside[index + grid.stride(axis)];
      if (from != to)
        grid.crossings.push_back({index, axis, from, Vector3f::Zero(), Vector3f::Zero()});
    }
  }
  const size_t count = grid.crossings.size();
  std::vector<Vector3f> points(count);
  std::vector<float> distances(count), low(count, 0), high(count, grid.cell_m);
  for (int i = 0; i < kBisections; ++i) {
    for (size_t k = 0; k < count; ++k) {
      points[k] = grid.Point(grid.crossings[k].corner);
      points[k][grid.crossings[k].axis] += 0.5f * (low[k] + high[k]);
    }
    solid.SignedDistances_m(points, distances);
    for (size_t k = 0; k < count; ++k) {
      const bool as_low_end = (distances[k] <= 0) == grid.crossings[k].leaves;
      (as_low_end ? low[k] : high[k]) = 0.5f * (low[k] + high[k]);
    }
  }
  for (size_t k = 0; k < count; ++k) {
    points[k] = grid.Point(grid.crossings[k].corner);
    points[k][grid.crossings[k].axis] += 0.5f * (low[k] + high[k]);
  }
  const std::vector<Vector3f> normals = solid.Normals(points, kNormalStep * grid.cell_m);
  for (size_t k = 0; k < count; ++k) {
    grid.crossings[k].point = points[k];
    grid.crossings[k].normal = normals[k];
  }
}

}  // namespace

Vector3i SolidGrid::Cell(int index) const {
  return {index % size.x(), index / size.x() % size.y(), index / (size.x() * size.y())};
}

Vector3f SolidGrid::Point(int index) const { return origin_O + cell_m * Cell(index).cast<float>(); }

SolidGrid SampleGrid(const SolidShape& solid, float cell_m) {
  SolidGrid grid;
  grid.cell_m = cell_m;
  grid.origin_O = solid.box_O().min() - cell_m * kShift;
  grid.size = (solid.box_O().sizes() / cell_m).array().ceil().cast<int>() + kMargin + 1;
  const double points = grid.size.cast<double>().prod();
  CheckInput(points <= kMaxPoints,
             fmt::format("a grid of {:.3g} points is too large for a solid; give it a thicker "
                         "min_wall_mm or use fewer cells",
                         points));
  grid.inside.resize(grid.size.prod());
  for (int z = 0; z < grid.size.z(); z += kBlockPoints) {
    for (int y = 0; y < grid.size.y(); y += kBlockPoints) {
      for (int x = 0; x < grid.size.x(); x += kBlockPoints) FillBlock(solid, {x, y, z}, grid);
    }
  }
  FindCrossings(solid, grid);
  return grid;
}

}  // namespace pickbed::scenes
