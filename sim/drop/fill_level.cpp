#include "sim/drop/fill_level.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pickbed::sim {
namespace {

constexpr int kCellsAlongBin = 200;  // of the longer side

// The cells that an instance covers, with the height of its upper surface.
struct TopView {
  struct Cell {
    int index;
    float height_m;
  };
  std::vector<Cell> cells;
};

class FloorGrid {
 public:
  explicit FloorGrid(const Bin& bin)
      : low_m_(-0.5 * bin.inner_size_m.head<2>()),
        cell_m_(bin.inner_size_m.head<2>().maxCoeff() / kCellsAlongBin),
        columns_(std::max(1, static_cast<int>(std::lround(bin.inner_size_m.x() / cell_m_)))),
        rows_(std::max(1, static_cast<int>(std::lround(bin.inner_size_m.y() / cell_m_)))),
        height_m_(static_cast<size_t>(columns_) * rows_, 0.0f) {}

  size_t size() const { return height_m_.size(); }

  TopView View(const TriangleMesh& mesh_O, const Pose& X_WO) {
    std::vector<Eigen::Vector3d> corners;  // x and y in cells
    corners.reserve(mesh_O.vertices.size());
    for (const Eigen::Vector3d& p_O : mesh_O.vertices) {
      const Eigen::Vector3d p_W = X_WO * p_O;
      corners.emplace_back((p_W.x() - low_m_.x()) / cell_m_, (p_W.y() - low_m_.y()) / cell_m_,
                           p_W.z());
    }
    for (const Eigen::Vector3i& t : mesh_O.triangles) {
      AddTriangle(corners[t[0]], corners[t[1]], corners[t[2]]);
    }
    TopView view;
    std::sort(covered_.begin(), covered_.end());
    for (const int cell : covered_) {
      view.cells.push_back({cell, height_m_[cell]});
      height_m_[cell] = 0;
    }
    covered_.clear();
    return view;
  }

 private:
  // Raises the cells whose centers are inside the triangle to its height there.
  void AddTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double area = (b - a).head<2>().x() * (c - a).y() - (b - a).y() * (c - a).x();
    if (std::abs(area) < 1e-9) return;  // a vertical triangle
    const Eigen::Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const int x0 = std::max(0, static_cast<int>(std::ceil(low.x() - 0.5)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(low.y() - 0.5)));
    const int x1 = std::min(columns_ - 1, static_cast<int>(std::floor(high.x() - 0.5)));
    const int y1 = std::min(rows_ - 1, static_cast<int>(std::floor(high.y() - 0.5)));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Eigen::Vector2d p(x + 0.5, y + 0.5);
        const double v = ((p.x() - a.x()) * (c.y() - a.y()) - (p.y() - a.y()) * (c.x() - a.x()));
        const double w = ((b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x()));
        const double share_b = v / area, share_c = w / area;
        if (share_b < 0 || share_c < 0 || share_b + share_c > 1) continue;
        const double z_m = a.z() + share_b * (b.z() - a.z()) + share_c * (c.z() - a.z());
        Raise(y * columns_ + x, static_cast<float>(z_m));
      }
    }
  }

  void Raise(int cell, float z_m) {
    if (z_m <= height_m_[cell]) return;
    if (height_m_[cell] == 0) covered_.push_back(cell);
    height_m_[cell] = z_m;
  }

  Eigen::Vector2d low_m_;
  double cell_m_;
  int columns_, rows_;
  std::vector<float> height_m_;  // of the instance that is being viewed
  std::vector<int> covered_;
};

// Returns the height of the surface in each cell, over the views that are `in`.
std::vector<float> SurfaceOf(const std::vector<TopView>& views, const std::vector<bool>& in,
                             size_t cells) {
  std::vector<float> surface_m(cells, 0.0f);
  for (size_t i = 0; i < views.size(); ++i) {
    if (!in[i]) continue;
    for (const TopView::Cell& cell : views[i].cells) {
      surface_m[cell.index] = std::max(surface_m[cell.index], cell.height_m);
    }
  }
  return surface_m;
}

// Returns the share of the view's cells in which it is the surface. An instance without cells, such
// as one smaller than a cell or outside the bin, is uncovered.
double UncoveredShare(const TopView& view, const std::vector<float>& surface_m) {
  if (view.cells.empty()) return 1;
  const auto uncovered = std::count_if(
      view.cells.begin(), view.cells.end(),
      [&](const TopView::Cell& cell) { return cell.height_m >= surface_m[cell.index]; });
  return static_cast<double>(uncovered) / static_cast<double>(view.cells.size());
}

std::vector<int> LayersOf(const std::vector<TopView>& views, size_t cells) {
  constexpr double kMinUncovered = 0.5;
  std::vector<int> layers(views.size(), 0);
  std::vector<bool> in(views.size(), true);
  for (int layer = 1; std::find(in.begin(), in.end(), true) != in.end(); ++layer) {
    const std::vector<float> surface_m = SurfaceOf(views, in, cells);
    double max_uncovered = 0;
    std::vector<double> uncovered(views.size(), 0.0);
    for (size_t i = 0; i < views.size(); ++i) {
      if (!in[i]) continue;
      uncovered[i] = UncoveredShare(views[i], surface_m);
      max_uncovered = std::max(max_uncovered, uncovered[i]);
    }
    // Instances that cover each other by more than half would never get a layer.
    const double limit = std::min(kMinUncovered, max_uncovered);
    for (size_t i = 0; i < views.size(); ++i) {
      if (!in[i] || uncovered[i] < limit) continue;
      layers[i] = layer;
      in[i] = false;
    }
  }
  return layers;
}

void CountNeighbors(const std::vector<TopView>& views, size_t cells, FillStatistics& fill) {
  struct Surface {
    int instance;
    float height_m;
  };
  std::vector<std::vector<Surface>> by_cell(cells);
  const int count = static_cast<int>(views.size());
  for (int i = 0; i < count; ++i) {
    for (const TopView::Cell& cell : views[i].cells) {
      by_cell[cell.index].push_back({i, cell.height_m});
    }
  }
  // Number of cells in which the first instance is higher than the second.
  std::vector<int> higher(static_cast<size_t>(count) * count, 0);
  const auto of = [&](int a, int b) -> int& { return higher[static_cast<size_t>(a) * count + b]; };
  for (const std::vector<Surface>& surfaces : by_cell) {
    for (const Surface& a : surfaces) {
      for (const Surface& b : surfaces) of(a.instance, b.instance) += a.height_m > b.height_m;
    }
  }
  fill.above.assign(count, 0);
  fill.below.assign(count, 0);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) {
      if (of(a, b) <= of(b, a)) continue;
      ++fill.below[a];
      ++fill.above[b];
    }
  }
}

}  // namespace

FillStatistics MeasureFill(const Scene& scene, const ObjectSet& objects) {
  FillStatistics fill;
  if (scene.objects.empty()) return fill;
  FloorGrid grid(scene.bin);
  std::vector<TopView> views;
  for (const PosedObject& posed : scene.objects) {
    views.push_back(grid.View(objects.at(posed.object)->mesh_O, posed.X_WO));
  }
  const std::vector<float> surface_m =
      SurfaceOf(views, std::vector<bool>(views.size(), true), grid.size());
  if (scene.bin.inner_size_m.z() > 0) {
    const double mean_m = std::accumulate(surface_m.begin(), surface_m.end(), 0.0) /
                          static_cast<double>(surface_m.size());
    fill.fill_level = mean_m / scene.bin.inner_size_m.z();
  }
  fill.layers = LayersOf(views, grid.size());
  CountNeighbors(views, grid.size(), fill);
  return fill;
}

}  // namespace pickbed::sim
