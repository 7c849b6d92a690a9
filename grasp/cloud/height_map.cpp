#include "grasp/cloud/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

constexpr float kEmpty = -std::numeric_limits<float>::infinity();
constexpr float kUnlimited = std::numeric_limits<float>::infinity();
constexpr float kMaxCells = 8192;  // along each side of a map

// Whether the column of a cell passes through the inside of the bin at the height of its rim.
bool IsInBin(const HeightMap& map, const Bin& bin, int column, int row) {
  const Eigen::Vector3d up = -map.R_BG.col(2);
  const Eigen::Vector3d p = map.PointIn_B(map.X_m(column), map.Y_m(row), 0);
  if (!(up.z() > 0)) return true;
  const Eigen::Vector3d rim = p + up * ((bin.inner_size_m.z() - p.z()) / up.z());
  return (rim.head<2>().array().abs() < 0.5 * bin.inner_size_m.head<2>().array()).all();
}

void FillEmptyCells(const Bin* bin, HeightMap& map) {
  constexpr int kNeighbors = 8;
  const std::vector<float> before = map.solid_m;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      float& value = map.solid_m[map.Index(column, row)];
      if (value != kEmpty) continue;
      int seen = 0;
      float highest = kEmpty;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!map.Contains(column + dx, row + dy)) continue;
          const float neighbor = before[map.Index(column + dx, row + dy)];
          seen += neighbor != kEmpty;
          highest = std::max(highest, neighbor);
        }
      }
      if (2 * seen >= kNeighbors) {
        value = highest;
      } else if (bin == nullptr || IsInBin(map, *bin, column, row)) {
        value = kUnlimited;
      }
    }
  }
}

// Maximum of `count` values, `step` apart, over windows of 2 * half + 1. Blocks of the window's
// length have running maxima from both ends (van Herk 1992), so the cost does not depend on it.
void RunningMax(const float* from, float* to, int count, int step, int half,
                std::vector<float>& forward, std::vector<float>& backward) {
  const int window = 2 * half + 1, padded = count + 2 * half;
  forward.resize(padded);
  backward.resize(padded);
  const auto value = [&](int i) {
    const int k = i - half;
    return k < 0 || k >= count ? kEmpty : from[static_cast<ptrdiff_t>(k) * step];
  };
  for (int i = 0; i < padded; ++i) {
    forward[i] = i % window == 0 ? value(i) : std::max(forward[i - 1], value(i));
  }
  for (int i = padded - 1; i >= 0; --i) {
    const bool is_end = i == padded - 1 || (i + 1) % window == 0;
    backward[i] = is_end ? value(i) : std::max(backward[i + 1], value(i));
  }
  for (int k = 0; k < count; ++k) {
    to[static_cast<ptrdiff_t>(k) * step] = std::max(backward[k], forward[k + window - 1]);
  }
}

}  // namespace

HeightMap MakeHeightMap(const ObservedSurface& surface, const Eigen::Matrix3d& R_BG, double cell_m,
                        const Bin* bin) {
  HeightMap map;
  map.R_BG = R_BG;
  map.cell_m = cell_m;
  if (surface.points.empty()) return map;
  const Eigen::Matrix3f R_GB = R_BG.transpose().cast<float>();
  std::vector<Eigen::Vector3f> points_G;
  points_G.reserve(surface.points.size());
  Eigen::Array2f low = Eigen::Array2f::Constant(kUnlimited), high = -low;
  for (const SurfacePoint& point : surface.points) {
    points_G.push_back(R_GB * point.p_B);
    low = low.min(points_G.back().head<2>().array());
    high = high.max(points_G.back().head<2>().array());
  }
  const Eigen::Array2f extent_m = high - low;
  CheckInput((extent_m / static_cast<float>(cell_m) < kMaxCells).all(),
             fmt::format("the seen surface is {:.1f} m x {:.1f} m wide, too wide for a height map "
                         "with cells of {:g} m; check the unit of the depth",
                         extent_m.x(), extent_m.y(), cell_m));
  map.corner_m = low.matrix().cast<double>();
  map.columns = static_cast<int>((high.x() - low.x()) / cell_m) + 1;
  map.rows = static_cast<int>((high.y() - low.y()) / cell_m) + 1;
  const size_t cells = static_cast<size_t>(map.columns) * map.rows;
  map.solid_m.assign(cells, kEmpty);
  map.seen_m.assign(cells, kEmpty);
  map.segment.assign(cells, kBackground);
  const float per_m = static_cast<float>(1 / cell_m);
  for (size_t i = 0; i < points_G.size(); ++i) {
    const Eigen::Vector3f& p_G = points_G[i];
    const int column = std::min(map.columns - 1, static_cast<int>((p_G.x() - low.x()) * per_m));
    const int row = std::min(map.rows - 1, static_cast<int>((p_G.y() - low.y()) * per_m));
    const int cell = map.Index(column, row);
    const float height_m = -p_G.z();
    map.solid_m[cell] = std::max(map.solid_m[cell], height_m);
    if (surface.points[i].segment < 0 || height_m <= map.seen_m[cell]) continue;
    map.seen_m[cell] = height_m;
    map.segment[cell] = surface.points[i].segment;
  }
  FillEmptyCells(bin, map);
  return map;
}

std::vector<float> RunningMaxOfRows(const std::vector<float>& values, int columns, int rows,
                                    int half) {
  std::vector<float> result(values.size()), forward, backward;
  for (int row = 0; row < rows; ++row) {
    const ptrdiff_t begin = static_cast<ptrdiff_t>(row) * columns;
    RunningMax(values.data() + begin, result.data() + begin, columns, 1, half, forward, backward);
  }
  return result;
}

std::vector<float> RunningMaxOfColumns(const std::vector<float>& values, int columns, int rows,
                                       int half) {
  std::vector<float> result(values.size()), forward, backward;
  for (int column = 0; column < columns; ++column) {
    RunningMax(values.data() + column, result.data() + column, rows, columns, half, forward,
               backward);
  }
  return result;
}

}  // namespace pickbed::grasp
