#include "scenes/mesh_levels.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/mesh_checks.h"
#include "scenes/mesh_query.h"
#include "scenes/part_families.h"
#include "tests/sim/render_support.h"

namespace pickbed {
namespace {

double Farthest_m(const TriangleMesh& from, const MeshQuery& to, uint64_t seed) {
  Rng rng(seed);
  double worst_m = 0;
  for (const Eigen::Vector3d& p : SampleSurface(from, 8000, rng).points) {
    worst_m = std::max(worst_m, to.ClosestPoint(p).distance);
  }
  return worst_m;
}

// Samples other than those that the levels were measured with: a maximum over samples is no bound,
// so a quarter more is allowed.
TEST(MeshLevels, StayWithinTheirDeviationBothWays) {
  for (const PartRow& row : PartTable()) {
    const TriangleMesh part = row.make().mesh_O;
    const MeshQuery original(part);
    const std::vector<MeshLevel> levels = MakeMeshLevels(part);
    EXPECT_EQ(levels[0].mesh.vertices, part.vertices);
    EXPECT_EQ(levels[0].deviation_m, 0);
    for (size_t i = 1; i < levels.size(); ++i) {
      const MeshLevel& level = levels[i];
      EXPECT_GE(level.deviation_m, levels[i - 1].deviation_m);
      EXPECT_LE(level.mesh.triangles.size(), 0.75 * levels[i - 1].mesh.triangles.size());
      EXPECT_LE(Farthest_m(level.mesh, original, i), 1.25 * level.deviation_m + 1e-5) << row.name;
      EXPECT_LE(Farthest_m(part, MeshQuery(level.mesh), i), 1.25 * level.deviation_m + 1e-5)
          << row.name;
    }
  }
}

TEST(MeshLevels, ClosedMeshesStayClosedAndKeepTheirSide) {
  for (const PartRow& row : PartTable()) {
    const TriangleMesh part = row.make().mesh_O;
    for (const MeshLevel& level : MakeMeshLevels(part)) {
      const MeshReport report = InspectMesh(level.mesh);
      EXPECT_TRUE(report.watertight()) << row.name << " " << level.deviation_m;
      EXPECT_GT(report.volume_m3, 0);
      EXPECT_EQ(level.mesh.normals.empty(), part.normals.empty());
    }
  }
}

TEST(MeshLevels, ADenseSphereBecomesMuchCoarser) {
  const std::vector<MeshLevel> levels = MakeMeshLevels(test::SphereMesh(0.04, 4));
  ASSERT_GE(levels.size(), 2u);
  EXPECT_LT(levels.back().mesh.triangles.size(), 500u);
}

TEST(MeshLevels, FlatFacesNeedNoTriangles) {
  // A plate of 20 x 20 squares: its border is open, its inside flat.
  TriangleMesh plate;
  for (int y = 0; y <= 20; ++y) {
    for (int x = 0; x <= 20; ++x) plate.vertices.push_back({0.01 * x, 0.01 * y, 0});
  }
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const int i = 21 * y + x;
      plate.triangles.push_back({i, i + 1, i + 22});
      plate.triangles.push_back({i, i + 22, i + 21});
    }
  }
  const std::vector<MeshLevel> levels = MakeMeshLevels(plate);
  ASSERT_GE(levels.size(), 2u);
  EXPECT_LE(levels[1].mesh.triangles.size(), 4u);
  EXPECT_LT(levels[1].deviation_m, 1e-9);
  EXPECT_NEAR(SurfaceArea(levels[1].mesh), SurfaceArea(plate), 1e-9);
}

TEST(MeshLevels, SmallMeshesAreLeftAlone) {
  EXPECT_EQ(MakeMeshLevels(test::BoxMesh({1, 1, 1})).size(), 1u);
}

// uvs of a texture are carried by vertices that stay, and seams do not move.
TEST(MeshLevels, TextureStaysInPlace) {
  TriangleMesh sphere = test::SphereMesh(0.05, 4);
  sphere.texture = Image<Rgb8>(4, 4);
  for (const Eigen::Vector3d& v : sphere.vertices) sphere.uvs.push_back(10 * v.head<2>());
  const std::vector<MeshLevel> levels = MakeMeshLevels(sphere);
  ASSERT_GE(levels.size(), 2u);
  for (const MeshLevel& level : levels) {
    ASSERT_EQ(level.mesh.uvs.size(), level.mesh.vertices.size());
    for (size_t i = 0; i < level.mesh.uvs.size(); ++i) {
      EXPECT_TRUE(level.mesh.uvs[i].isApprox(10 * level.mesh.vertices[i].head<2>()));
    }
  }
}

}  // namespace
}  // namespace pickbed
