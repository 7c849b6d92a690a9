#include "perception/completion/rule_completers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "perception/completion/completion_input.h"
#include "perception/completion/network_completer.h"

namespace pickbed::perception {
namespace {

// The seen surface on a grid of rays: the cell of a ray is where it meets the center plane of the
// cube, which is square to the camera's axis.
class SurfaceGrid {
 public:
  SurfaceGrid(const CompletionInput& input, int cells)
      : cube_(input.cube()),
        cell_m_(input.cube().side_m / static_cast<float>(cells)),
        plane_z_m_(input.cube().origin_C.z() + 0.5f * input.cube().side_m),
        front_m(cells, cells, 0) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const Eigen::Vector3f p_C = Point_C(x, y);
        float depth_m = 0;
        if (input.ClassAt(p_C, depth_m) == PixelClass::kSegment) front_m(x, y) = depth_m;
      }
    }
    FillHoles();
  }

  Eigen::Vector3f Point_C(int x, int y) const {
    return {cube_.origin_C.x() + (static_cast<float>(x) + 0.5f) * cell_m_,
            cube_.origin_C.y() + (static_cast<float>(y) + 0.5f) * cell_m_, plane_z_m_};
  }
  // Finds the cell of the ray through a point. Returns false if it is outside the grid.
  bool CellOf(const Eigen::Vector3f& p_C, int& x, int& y) const {
    const float scale = plane_z_m_ / p_C.z();
    x = static_cast<int>(std::floor((p_C.x() * scale - cube_.origin_C.x()) / cell_m_));
    y = static_cast<int>(std::floor((p_C.y() * scale - cube_.origin_C.y()) / cell_m_));
    return front_m.Contains(x, y);
  }
  float cell_m() const { return cell_m_; }

 private:
  // A hole of one cell between two seen cells gets their mean.
  void FillHoles() {
    const Image<float> seen = front_m;
    for (int y = 0; y < seen.height(); ++y) {
      for (int x = 0; x < seen.width(); ++x) {
        if (seen(x, y) > 0) continue;
        for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
          if (!seen.Contains(x - dx, y - dy) || !seen.Contains(x + dx, y + dy)) continue;
          const float before = seen(x - dx, y - dy), after = seen(x + dx, y + dy);
          if (before > 0 && after > 0) front_m(x, y) = 0.5f * (before + after);
        }
      }
    }
  }

  CompletionCube cube_;
  float cell_m_, plane_z_m_;

 public:
  Image<float> front_m;  // depth of the seen surface, 0 = the ray does not meet the segment
};

// Returns the diameter of the widest circle of seen cells that contains each cell, in cells.
Image<float> WidestCircles(const Image<float>& front_m) {
  const int n = front_m.width();
  Image<float> diameters(n, n, 0);
  std::vector<Eigen::Vector2i> outside;
  for (int y = -1; y <= n; ++y) {
    for (int x = -1; x <= n; ++x) {
      const bool seen = front_m.Contains(x, y) && front_m(x, y) > 0;
      bool beside = false;
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        beside |= front_m.Contains(x + dx, y + dy) && front_m(x + dx, y + dy) > 0;
      }
      if (!seen && beside) outside.emplace_back(x, y);
    }
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      if (!(front_m(x, y) > 0)) continue;
      int nearest = 2 * n * n;
      for (const Eigen::Vector2i& p : outside) {
        nearest = std::min(nearest, (p - Eigen::Vector2i(x, y)).squaredNorm());
      }
      // The border of the silhouette is half a cell before the center of the outer cell.
      const float radius = std::sqrt(static_cast<float>(nearest)) - 0.5f;
      const int reach = static_cast<int>(radius);
      for (int v = std::max(0, y - reach); v <= std::min(n - 1, y + reach); ++v) {
        for (int u = std::max(0, x - reach); u <= std::min(n - 1, x + reach); ++u) {
          const auto squared = static_cast<float>((u - x) * (u - x) + (v - y) * (v - y));
          if (squared <= radius * radius) diameters(u, v) = std::max(diameters(u, v), 2 * radius);
        }
      }
    }
  }
  return diameters;
}

// Returns the extent of the seen cells along the axis of their least spread, in cells.
float SmallerWidth(const Image<float>& front_m) {
  std::vector<Eigen::Vector2f> cells;
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (int y = 0; y < front_m.height(); ++y) {
    for (int x = 0; x < front_m.width(); ++x) {
      if (front_m(x, y) > 0) cells.emplace_back(x, y);
    }
  }
  if (cells.empty()) return 0;
  for (const Eigen::Vector2f& cell : cells) mean += cell / static_cast<float>(cells.size());
  Eigen::Matrix2f spread = Eigen::Matrix2f::Zero();
  for (const Eigen::Vector2f& cell : cells) spread += (cell - mean) * (cell - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> solver;
  solver.computeDirect(spread);
  const Eigen::Vector2f axis = solver.eigenvectors().col(0);
  float low = 1e9f, high = -1e9f;
  for (const Eigen::Vector2f& cell : cells) {
    low = std::min(low, axis.dot(cell));
    high = std::max(high, axis.dot(cell));
  }
  return high - low + 1;
}

class RuleCompleter : public ShapeCompleter {
 public:
  RuleCompleter(CompletionRule rule, const CompletionOptions& options)
      : rule_(rule), options_(options) {}

  CompletedVolume Complete(const SegmentView& view) override {
    const CompletionInput input(view);
    const SurfaceGrid grid(input, options_.cells);
    const Image<float> back_m = Backs(grid);
    CompletedVolume volume = EmptyVolume(input.cube(), options_.cells);
    for (int z = 0; z < volume.size; ++z) {
      for (int y = 0; y < volume.size; ++y) {
        for (int x = 0; x < volume.size; ++x) {
          const Eigen::Vector3f p_C = volume.Center_C(x, y, z);
          int column = 0, row = 0;
          if (!grid.CellOf(p_C, column, row) || !(grid.front_m(column, row) > 0)) continue;
          const bool within =
              p_C.z() >= grid.front_m(column, row) && p_C.z() <= back_m(column, row);
          const bool below = view.floor && view.floor->Height_m(p_C) < 0;
          if (within && !below) volume.occupancy[volume.Index(x, y, z)] = 1;
        }
      }
    }
    return volume;
  }

 private:
  // Returns the depth up to which the rays are inside.
  Image<float> Backs(const SurfaceGrid& grid) const {
    Image<float> back_m = grid.front_m;
    float nearest_m = 1e9f, deepest_m = 0;
    for (const float z : grid.front_m.pixels()) {
      if (!(z > 0)) continue;
      nearest_m = std::min(nearest_m, z);
      deepest_m = std::max(deepest_m, z);
    }
    Image<float> circles;
    if (rule_ == CompletionRule::kLocalThickness) circles = WidestCircles(grid.front_m);
    const float width_m =
        rule_ == CompletionRule::kExtrusion ? SmallerWidth(grid.front_m) * grid.cell_m() : 0;
    for (size_t i = 0; i < back_m.size(); ++i) {
      float& z = back_m.pixels()[i];
      switch (rule_) {
        case CompletionRule::kLocalThickness:
          z += circles.pixels()[i] * grid.cell_m();
          break;
        case CompletionRule::kSkirt:
          z += static_cast<float>(options_.skirt_m);
          break;
        case CompletionRule::kMirror:
          z = 2 * deepest_m - z;
          break;
        case CompletionRule::kExtrusion:
          z = std::max(nearest_m + width_m, z + grid.cell_m());
          break;
      }
    }
    return back_m;
  }

  CompletionRule rule_;
  CompletionOptions options_;
};

}  // namespace

std::unique_ptr<ShapeCompleter> MakeRuleCompleter(CompletionRule rule,
                                                  const CompletionOptions& options) {
  return std::make_unique<RuleCompleter>(rule, options);
}

}  // namespace pickbed::perception
