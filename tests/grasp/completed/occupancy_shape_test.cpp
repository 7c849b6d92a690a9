#include "grasp/completed/occupancy_shape.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <numeric>

#include "scenes/geometry/mass_properties.h"
#include "tests/grasp/completed/shape_source.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

TEST(SurfaceOf, ASphereHasItsRadiusItsVolumeAndAClosedSurface) {
  constexpr double kRadius_m = 0.03;
  const OccupancyShape shape = SphereShape(kRadius_m, Pose::Identity());
  const TriangleMesh mesh = Transformed(SurfaceOf(Smoothed(shape), 0.5), shape.X_WV);
  ASSERT_FALSE(mesh.triangles.empty());
  for (const Vector3d& p : mesh.vertices) EXPECT_NEAR(p.norm(), kRadius_m, 0.7 * shape.cell_m);
  std::map<std::pair<int, int>, int> sides;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [side, count] : sides) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(sides.count({side.second, side.first}), 1u) << "a neighbour on the other side";
  }
  // A positive volume means that the triangles face outwards.
  const double volume_m3 = UniformDensityProperties(mesh, 1000).volume_m3;
  EXPECT_NEAR(volume_m3 / (4.0 / 3 * std::numbers::pi * std::pow(kRadius_m, 3)), 1, 0.06);
}

TEST(SurfaceOf, IsClosedAtTheBorderOfTheGridAndEmptyWithoutMatter) {
  OccupancyShape full;
  full.cell_m = 0.01;
  full.size = 4;
  full.occupancy.assign(64, 1);
  const TriangleMesh mesh = SurfaceOf(full, 0.5);
  const Bounds bounds = MeshBounds(mesh);
  EXPECT_NEAR(bounds.min.x(), 0, 1e-9) << "half way to the empty cells outside";
  EXPECT_NEAR(bounds.max.z(), 0.04, 1e-9);
  full.occupancy.assign(64, 0.2f);
  EXPECT_TRUE(SurfaceOf(full, 0.5).triangles.empty());
}

TEST(Smoothed, KeepsTheSumAwayFromTheBorderAndSoftensEdges) {
  const OccupancyShape shape = BoxShape({0.04, 0.03, 0.02}, Pose::Identity(), 24);
  const OccupancyShape smooth = Smoothed(shape);
  const auto sum = [](const OccupancyShape& s) {
    return std::accumulate(s.occupancy.begin(), s.occupancy.end(), 0.0);
  };
  EXPECT_NEAR(sum(smooth) / sum(shape), 1, 1e-5);
  const auto soft = std::count_if(smooth.occupancy.begin(), smooth.occupancy.end(),
                                  [](float p) { return p > 0.1 && p < 0.9; });
  EXPECT_GT(soft, 100);
}

TEST(ShellOf, IsTheOutermostLayerOfTheCells) {
  const OccupancyShape shape = BoxShape({0.04, 0.03, 0.02}, Pose::Identity(), 32);
  const std::vector<Vector3d> shell = ShellOf(shape, 0.5);
  // The box has 24 x 18 x 12 cells of 1.625 mm.
  EXPECT_EQ(shell.size(), 24u * 18 * 12 - 22u * 16 * 10);
  for (const Vector3d& p : shell) {
    const double outside = (p.cwiseAbs() - Vector3d(0.02, 0.015, 0.01)).maxCoeff();
    EXPECT_LT(outside, 0);
    EXPECT_GT(outside, -1.01 * shape.cell_m);
  }
}

}  // namespace
}  // namespace pickbed::tests
