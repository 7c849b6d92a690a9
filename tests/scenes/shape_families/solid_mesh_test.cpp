#include "scenes/shape_families/solid_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/random.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/shape_families/shape_family.h"
#include "scenes/shape_families/solid_builder.h"
#include "scenes/shape_families/solid_grid.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Returns the share of random points in the box for which `is_inside` holds.
template <typename IsInside>
double Fill(const SolidShape& solid, int count, const IsInside& is_inside) {
  Rng rng(1);
  int inside = 0;
  for (int i = 0; i < count; ++i) {
    Vector3f p;
    for (int k = 0; k < 3; ++k) {
      p[k] = static_cast<float>(rng.Uniform(-0.5, 0.5)) * solid.box_O().sizes()[k];
    }
    inside += is_inside(p);
  }
  return static_cast<double>(inside) / count;
}

TEST(SolidMesh, VolumeAndAreaOfABoxAreExact) {
  const TriangleMesh mesh = MeshOfSolid(CompiledSolid(Box({40, 60, 80}), 20));
  EXPECT_NEAR(InspectMesh(mesh).volume_m3, 40 * 60 * 80e-9, 1e-9);
  EXPECT_NEAR(SurfaceArea(mesh), 2 * (40 * 60 + 60 * 80 + 80 * 40) * 1e-6, 1e-7);
  EXPECT_LT(mesh.triangles.size(), 60u) << "flat sides are reduced";
}

TEST(SolidMesh, SharpEdgesStaySharp) {
  const TriangleMesh mesh = MeshOfSolid(CompiledSolid(
      Turned(Cut(Box({60, 60, 60}), Moved(Box({60, 60, 60}), {30, 30, 30})), {1, 2, 3}, 25), 20));
  const double cube = 60e-3;
  EXPECT_NEAR(InspectMesh(mesh).volume_m3, cube * cube * cube * 7 / 8, 5e-8);
}

// The grid's own check: a crossing is on the surface, and its normal leaves the solid.
TEST(SolidGrid, CrossingsAreOnTheSurface) {
  const SolidShape solid = CompiledSolid(Torus(30, 10), 10);
  const SolidGrid grid = SampleGrid(solid, 2e-3f);
  ASSERT_GT(grid.crossings.size(), 1000u);
  for (const GridCrossing& crossing : grid.crossings) {
    EXPECT_NEAR(solid.SignedDistance_m(crossing.point), 0, 1e-6);
    EXPECT_FALSE(solid.Contains(crossing.point + 1e-4f * crossing.normal));
    EXPECT_EQ(grid.inside[crossing.corner], crossing.leaves);
  }
}

TEST(SolidMesh, AThinWallSurvives) {
  const SolidShape solid =
      CompiledSolid(Turned(Shelled(Box({100, 60, 40}), 1.5), Vector3d(1, 1, 0), 20), 1.5);
  const TriangleMesh mesh = MeshOfSolid(solid);
  const double outer = 100 * 60 * 40e-9, inner = 97 * 57 * 37e-9;
  EXPECT_NEAR(InspectMesh(mesh).volume_m3, outer - inner, 0.03 * (outer - inner));
}

// Two balls that nearly touch share cells of the grid; both sheets must stay closed.
TEST(SolidMesh, SheetsInOneCellAreSeparated) {
  for (const double gap : {0.02, 0.2, 0.7, 1.4}) {
    for (int turn = 0; turn < 6; ++turn) {
      const Solid balls = Mirrored(Moved(Sphere(20), {20 + 0.5 * gap, 0, 0}), true, false, false);
      const Solid turned = Turned(balls, {1, 0.3 * turn, 0.7}, 17.0 * turn);
      const MeshReport report =
          InspectMesh(MeshOfSolid(CompiledSolid(turned, 20), {.cells = 32, .tolerance_share = 0}));
      EXPECT_TRUE(report.watertight()) << gap << " mm, turn " << turn;
      EXPECT_EQ(report.flipped_edges, 0);
    }
  }
}

class FamilyMesh : public testing::TestWithParam<const ShapeFamilyRow*> {};

// Not reduced, which takes most of the time of a mesh.
constexpr SolidMeshOptions kCoarse{.cells = 32, .cells_per_wall = 1.8, .tolerance_share = 0};

TEST_P(FamilyMesh, IsClosedAndAgreesWithTheOracle) {
  const ShapeSplit splits[] = {ShapeSplit::kSeen, ShapeSplit::kUnseenSizes, ShapeSplit::kOutside};
  for (int i = 0; i < 3; ++i) {
    const SampledShape shape = SampleShape(*GetParam(), splits[i], 20 + i);
    SCOPED_TRACE(ShapeSplitName(shape.split));
    const TriangleMesh mesh = MeshOfSolid(shape.solid, kCoarse);
    const MeshReport report = InspectMesh(mesh);
    EXPECT_TRUE(report.watertight());
    EXPECT_EQ(report.flipped_edges, 0);
    EXPECT_GT(report.volume_m3, 0) << "the outside is in front";
    EXPECT_EQ(mesh.normals.size(), mesh.vertices.size());

    const double box_m3 = shape.solid.box_O().sizes().cast<double>().prod();
    const double fill =
        Fill(shape.solid, 40000, [&](const Vector3f& p) { return shape.solid.Contains(p); });
    const double deviation = std::sqrt(fill * (1 - fill) / 40000);
    EXPECT_NEAR(report.volume_m3 / box_m3, fill, 4 * deviation + 0.025 * fill);

    // The parity of crossings along a general direction decides what is inside the mesh.
    const MeshQuery query(mesh);
    const Vector3d direction = Vector3d(0.31, 0.52, 0.79).normalized();
    // Features that are smaller than a cell are rounded off.
    const float near = 0.01f * shape.solid.box_O().sizes().maxCoeff();
    Rng rng(3);
    int compared = 0, wrong = 0;
    for (int k = 0; k < 300; ++k) {
      Vector3f p;
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] = static_cast<float>(rng.Uniform(-0.55, 0.55)) * shape.solid.box_O().sizes()[axis];
      }
      const float distance = shape.solid.SignedDistance_m(p);
      if (std::abs(distance) < near) continue;
      int ahead = 0;
      for (const SurfaceHit& hit : query.AllHits(p.cast<double>(), direction)) {
        ahead += hit.distance > 0;
      }
      ++compared;
      wrong += (ahead % 2 == 1) != (distance < 0);
    }
    EXPECT_GT(compared, 50);
    EXPECT_EQ(wrong, 0);
  }
}

std::vector<const ShapeFamilyRow*> AllRows() {
  std::vector<const ShapeFamilyRow*> rows;
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) rows.push_back(&row);
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Families, FamilyMesh, testing::ValuesIn(AllRows()),
                         [](const auto& info) { return std::string(info.param->name); });

TEST(SolidMesh, TheReducedMeshIsClosedAndNear) {
  for (const char* name : {"nut", "cup", "rod_with_eyes", "bottle", "random_union"}) {
    const SampledShape shape = SampleShape(FindShapeFamily(name), ShapeSplit::kSeen, 3);
    const TriangleMesh mesh = MeshOfSolid(shape.solid, {.cells = 32, .tolerance_share = 1e-3});
    EXPECT_TRUE(InspectMesh(mesh).watertight()) << name;
    EXPECT_EQ(InspectMesh(mesh).flipped_edges, 0) << name;
    EXPECT_LT(mesh.triangles.size(), 8000u) << name;
    const float size_m = shape.solid.box_O().sizes().maxCoeff();
    Rng rng(4);
    for (const Vector3d& p : SampleSurface(mesh, 500, rng).points) {
      EXPECT_NEAR(shape.solid.SignedDistance_m(p.cast<float>()), 0, 0.01f * size_m) << name;
    }
  }
}

TEST(SolidMesh, SameSeedGivesTheSameBytes) {
  const auto hash = [](int seed) {
    return MeshHash(
        MeshOfSolid(SampleShape(FindShapeFamily("flange"), ShapeSplit::kSeen, seed).solid));
  };
  EXPECT_EQ(hash(3), hash(3));
  EXPECT_NE(hash(3), hash(4));
}

TEST(SolidMesh, RefusesBadOptions) {
  const SolidShape ball = CompiledSolid(Sphere(20), 20);
  EXPECT_EQ(ErrorOf([&] { MeshOfSolid(ball, {.cells = 4}); }), "cells: 4 is not within 8 to 512");
  EXPECT_EQ(ErrorOf([&] { MeshOfSolid(ball, {.cells_per_wall = 0}); }),
            "cells_per_wall: 0 is not within 1 to 10");
  EXPECT_EQ(ErrorOf([&] { MeshOfSolid(ball, {.tolerance_share = -1}); }),
            "tolerance_share: -1 is not within 0 to 0.1");
  EXPECT_EQ(ErrorOf([] { MeshOfSolid(SolidShape()); }), "an empty solid has no surface");
  EXPECT_THAT(ErrorOf([&] { SampleGrid(ball, 1e-6f); }), testing::HasSubstr("too large"));
}

}  // namespace
}  // namespace pickbed::tests
