#include "grasp/completed/hand_surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/math.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/filled_depth.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kCell_m = 0.005;
constexpr int kCellsX = 24, kCellsY = 16, kCellsZ = 16;
constexpr double kTop_m = -0.05;     // of the cells, above the finger tips
constexpr double kSurface_m = 0.02;  // distance from the surface that counts as 1
constexpr int kRegionsX = 4, kRegionsY = 3, kRegionsZ = 6;
constexpr int kQuantities = 3;
constexpr int kRegions = kRegionsX * kRegionsY * kRegionsZ;
static_assert(kSurroundingsValues == kRegions * kQuantities * 2);

// Ends of the regions. Along x, they are distances from the inner side of a finger.
constexpr std::array<double, kRegionsX> kEndsX_m = {-0.004, 0.01, 0.025, 0.06};
constexpr std::array<double, kRegionsY> kEndsY_m = {0.011, 0.025, 0.04};
constexpr std::array<double, kRegionsZ> kEndsZ_m = {-0.03, -0.015, -0.005, 0.005, 0.015, 0.03};

// Returns the region of a value; the number of regions beyond the last.
template <size_t kCount>
int RegionOf(double value_m, const std::array<double, kCount>& ends_m) {
  return static_cast<int>(std::upper_bound(ends_m.begin(), ends_m.end(), value_m) - ends_m.begin());
}

double CenterX_m(int x) { return (x + 0.5 - kCellsX / 2) * kCell_m; }
double CenterY_m(int y) { return (y + 0.5 - kCellsY / 2) * kCell_m; }
double CenterZ_m(int z) { return kTop_m + (z + 0.5) * kCell_m; }

// Sums of the cells of a region on one side of the hand.
struct Sums {
  int cells = 0;
  std::array<double, kQuantities> values = {};
  double Mean(int quantity) const { return cells > 0 ? values[quantity] / cells : 0; }
};

}  // namespace

HandSurroundings::HandSurroundings(const PlannerInput& input, const ImageSegments& segments,
                                   std::span<const OccupancyShape> shapes)
    : input_(input), segments_(segments), shapes_(shapes) {
  for (const OccupancyShape& shape : shapes_) X_VW_.push_back(shape.X_WV.inverse());
}

std::vector<float> HandSurroundings::Of(const Pose& X_WG, double opening_m,
                                        const SegmentMeasures* own) const {
  // Most shapes are far away from the hand.
  struct Near {
    const OccupancyShape* shape;
    Pose X_VG;
  };
  std::vector<Near> near;
  const Vector3d reach_m(kCellsX * kCell_m / 2, kCellsY * kCell_m / 2, -kTop_m);
  for (size_t i = 0; i < shapes_.size(); ++i) {
    if (shapes_[i].size == 0) continue;
    const double half_m = shapes_[i].cell_m * shapes_[i].size / 2;
    const Pose X_VG = X_VW_[i] * X_WG;
    const double distance_m = (X_VG.translation() - Vector3d::Constant(half_m)).norm();
    if (distance_m < half_m * std::sqrt(3.0) + reach_m.norm()) near.push_back({&shapes_[i], X_VG});
  }
  const int own_label = own == nullptr ? 0 : static_cast<int>(own - segments_.segments.data()) + 1;
  const CameraIntrinsics& k = input_.frame.intrinsics;
  const Pose X_CG = input_.X_WC.inverse() * X_WG;

  std::array<std::array<Sums, 2>, kRegions> sums;
  for (int z = 0; z < kCellsZ; ++z) {
    const int region_z = RegionOf(CenterZ_m(z), kEndsZ_m);
    for (int y = 0; y < kCellsY; ++y) {
      const int region_y = RegionOf(std::abs(CenterY_m(y)), kEndsY_m);
      for (int x = 0; x < kCellsX; ++x) {
        const Vector3d p_G(CenterX_m(x), CenterY_m(y), CenterZ_m(z));
        const int region_x = RegionOf(std::abs(p_G.x()) - opening_m / 2, kEndsX_m);
        if (region_x == kRegionsX) continue;
        Sums& side = sums[(region_x * kRegionsY + region_y) * kRegionsZ + region_z][p_G.x() > 0];
        ++side.cells;
        const Vector3d p_C = X_CG * p_G;
        if (p_C.z() > 0) {
          const Eigen::Vector2d uv = Project(k, p_C);
          const double u = std::round(uv.x()), v = std::round(uv.y());
          if (u >= 0 && v >= 0 && u < k.width() && v < k.height()) {
            const int column = static_cast<int>(u), row = static_cast<int>(v);
            const float depth_m = input_.frame.depth_m(column, row);
            if (IsReading(depth_m)) {
              const double above_m = depth_m - p_C.z();
              side.values[0] += std::clamp(above_m / kSurface_m, -1.0, 1.0);
              const int label = segments_.segments.empty() ? 0 : segments_.labels(column, row);
              if (label != 0 && label != own_label && above_m < 0) side.values[1] += 1;
            }
          }
        }
        float probability = 0;
        for (const Near& object : near) {
          const Vector3d cell = object.X_VG * p_G / object.shape->cell_m;
          const auto index = [&](int axis) { return static_cast<int>(std::floor(cell[axis])); };
          probability = std::max(probability, object.shape->At(index(0), index(1), index(2)));
        }
        side.values[2] += probability;
      }
    }
  }
  std::vector<float> values;
  values.reserve(kSurroundingsValues);
  for (const auto& [left, right] : sums) {
    for (int quantity = 0; quantity < kQuantities; ++quantity) {
      const double a = left.Mean(quantity), b = right.Mean(quantity);
      values.push_back(static_cast<float>((a + b) / 2));
      values.push_back(static_cast<float>(std::abs(a - b)));
    }
  }
  return values;
}

}  // namespace pickbed::grasp
