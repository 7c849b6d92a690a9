#include "scenes/geometry/mesh_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/part_families/part_families.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

double LargestDistance_m(const TriangleMesh& from, const MeshQuery& to, uint64_t seed) {
  Rng rng(seed);
  double worst_m = 0;
  for (const Eigen::Vector3d& p : SampleSurface(from, 8000, rng).points) {
    worst_m = std::max(worst_m, to.ClosestPoint(p).distance);
  }
  return worst_m;
}

// The samples differ from those the levels were measured with. A maximum over samples is no bound,
// so the test allows 25 % more.
TEST(MeshLevels, StayWithinTheirDeviationInBothDirections) {
  for (const FamilyRow& row : FamilyTable()) {
    const TriangleMesh object = row.make().mesh_O;
    const MeshQuery original(object);
    const std::vector<MeshLevel> levels = MakeMeshLevels(object);
    EXPECT_EQ(levels[0].mesh.vertices, object.vertices);
    EXPECT_EQ(levels[0].deviation_m, 0);
    for (size_t i = 1; i < levels.size(); ++i) {
      const MeshLevel& level = levels[i];
      EXPECT_GE(level.deviation_m, levels[i - 1].deviation_m);
      EXPECT_LE(level.mesh.triangles.size(), 0.75 * levels[i - 1].mesh.triangles.size());
      EXPECT_LE(LargestDistance_m(level.mesh, original, i), 1.25 * level.deviation_m + 1e-5)
          << row.name;
      EXPECT_LE(LargestDistance_m(object, MeshQuery(level.mesh), i),
                1.25 * level.deviation_m + 1e-5)
          << row.name;
    }
  }
}

TEST(MeshLevels, ClosedMeshesStayClosedAndOutward) {
  for (const FamilyRow& row : FamilyTable()) {
    const TriangleMesh object = row.make().mesh_O;
    for (const MeshLevel& level : MakeMeshLevels(object)) {
      const MeshReport report = InspectMesh(level.mesh);
      EXPECT_TRUE(report.watertight()) << row.name << " " << level.deviation_m;
      EXPECT_GT(report.volume_m3, 0);
      EXPECT_EQ(level.mesh.normals.empty(), object.normals.empty());
    }
  }
}

TEST(MeshLevels, DenseSphereIsReduced) {
  const std::vector<MeshLevel> levels = MakeMeshLevels(SphereMesh(0.04, 4));
  ASSERT_GE(levels.size(), 2u);
  EXPECT_LT(levels.back().mesh.triangles.size(), 500u);
}

// Ends of the edges of only one triangle.
std::vector<Eigen::Vector3d> RimOf(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> triangles_of;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++triangles_of[std::minmax({t[k], t[(k + 1) % 3]})];
  }
  std::vector<Eigen::Vector3d> rim;
  for (const auto& [edge, count] : triangles_of) {
    if (count != 1) continue;
    rim.push_back(mesh.vertices[edge.first]);
    rim.push_back(mesh.vertices[edge.second]);
  }
  return rim;
}

// A dense and noisy cylinder without top and bottom, with a vertex of no triangle.
TriangleMesh ScannedTube(double radius_m, double height_m, double noise_m) {
  constexpr int kSides = 160, kRings = 60;
  TriangleMesh scan;
  Rng rng(2);
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      const double r = radius_m + rng.Uniform(-noise_m, noise_m);
      scan.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle),
                                 height_m * ring / kRings);
    }
  }
  for (int ring = 0; ring < kRings; ++ring) {
    for (int i = 0; i < kSides; ++i) {
      const int a = ring * kSides + i, b = ring * kSides + (i + 1) % kSides;
      scan.triangles.emplace_back(a, b, b + kSides);
      scan.triangles.emplace_back(a, b + kSides, a + kSides);
    }
  }
  scan.vertices.emplace_back(0, 0, 3 * height_m);
  return scan;
}

// Training draws a level within 0.2 % of the diameter.
TEST(MeshLevels, OpenScanIsReducedAndKeepsItsRim) {
  constexpr double kHeight_m = 0.1;
  const TriangleMesh scan = ScannedTube(0.04, kHeight_m, 3e-5);
  const std::vector<MeshLevel> levels = MakeMeshLevels(scan);
  const auto drawn = std::find_if(levels.rbegin(), levels.rend(), [&](const MeshLevel& level) {
    return level.deviation_m < 0.002 * std::hypot(0.08, kHeight_m);
  });
  EXPECT_LT(drawn->mesh.triangles.size(), scan.triangles.size() / 4) << levels[1].deviation_m;
  const std::vector<Eigen::Vector3d> rim = RimOf(drawn->mesh);
  ASSERT_FALSE(rim.empty());
  for (const Eigen::Vector3d& p : rim) {
    EXPECT_LT(std::min(p.z(), kHeight_m - p.z()), 1e-9) << "a hole, or the rim has moved";
  }
}

TEST(MeshLevels, FlatRegionsAreReducedWithoutDeviation) {
  // A plate of 20 x 20 squares: its border is open, its interior is flat.
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

TEST(MeshLevels, SmallMeshesGetNoCoarserLevel) {
  EXPECT_EQ(MakeMeshLevels(BoxMesh({1, 1, 1})).size(), 1u);
}

// The remaining vertices keep their uvs, and seams do not move.
TEST(MeshLevels, VerticesKeepTheirTextureCoordinates) {
  TriangleMesh sphere = SphereMesh(0.05, 4);
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
}  // namespace pickbed::tests
