#include "scenes/bin/bin.h"

#include <gtest/gtest.h>

#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

bool InsideSomeBox(const std::vector<AxisAlignedBox>& boxes, const Eigen::Vector3d& p) {
  for (const AxisAlignedBox& box : boxes) {
    if (((p - box.center).cwiseAbs() - box.half_size).maxCoeff() < 0) return true;
  }
  return false;
}

Bin MakeBin(double wall_height_m) {
  Bin bin;
  bin.inner_size_m = {0.4, 0.3, wall_height_m};
  bin.wall_m = 0.01;
  return bin;
}

TEST(BinMesh, IsClosedAndOccupiesTheSameSpaceAsTheBoxes) {
  for (const double height : {0.15, 0.0}) {
    const Bin bin = MakeBin(height);
    const TriangleMesh mesh = BinMesh(bin);
    const std::vector<AxisAlignedBox> boxes = BinBoxes(bin);
    const MeshReport report = InspectMesh(mesh);
    EXPECT_TRUE(report.watertight());
    EXPECT_EQ(report.flipped_edges, 0);
    double volume = 0;  // the boxes don't overlap
    for (const AxisAlignedBox& box : boxes) volume += 8 * box.half_size.prod();
    EXPECT_NEAR(report.volume_m3, volume, 1e-12);
    const MeshQuery query(mesh);
    Rng rng(1);
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d p(rng.Uniform(-0.25, 0.25), rng.Uniform(-0.2, 0.2),
                              rng.Uniform(-0.03, 0.2));
      int above = 0;
      for (const SurfaceHit& hit : query.AllHits(p, rng.UnitVector())) above += hit.distance > 0;
      EXPECT_EQ(above % 2 == 1, InsideSomeBox(boxes, p)) << p.transpose();
    }
  }
}

TEST(Bin, FloorIsAtZeroAndInnerSizeIsFree) {
  const Bin bin = MakeBin(0.15);
  const std::vector<AxisAlignedBox> boxes = BinBoxes(bin);
  EXPECT_EQ(boxes.size(), 5u);
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const Eigen::Vector3d corner(sx * 0.2, sy * 0.15, 0.0);
      const Eigen::Vector3d inward(-sx * 1e-6, -sy * 1e-6, 1e-6);
      EXPECT_FALSE(InsideSomeBox(boxes, corner + inward));
      const Eigen::Vector3d into_x(sx * 1e-6, -sy * 1e-6, 1e-6);
      const Eigen::Vector3d into_y(-sx * 1e-6, sy * 1e-6, 1e-6);
      EXPECT_TRUE(InsideSomeBox(boxes, corner + into_x));
      EXPECT_TRUE(InsideSomeBox(boxes, corner + into_y));
      EXPECT_TRUE(InsideSomeBox(boxes, corner - Eigen::Vector3d(0, 0, 1e-6)));
    }
  }
  const Bounds bounds = MeshBounds(BinMesh(bin));
  EXPECT_TRUE(bounds.min.isApprox(Eigen::Vector3d(-0.21, -0.16, -0.01), 1e-12));
  EXPECT_TRUE(bounds.max.isApprox(Eigen::Vector3d(0.21, 0.16, 0.15), 1e-12));
}

TEST(Bin, ZeroWallHeightGivesATable) {
  EXPECT_EQ(BinBoxes(MakeBin(0)).size(), 1u);
  EXPECT_NEAR(MeshBounds(BinMesh(MakeBin(0))).max.z(), 0, 1e-12);
}

}  // namespace
}  // namespace pickbed::tests
