// Meshes from other sources: scans, machine parts and difficult importer cases. Skipped if they are
// absent; mesh_io_test.cpp has a small generated mesh for each difficult case.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/geometry/symmetry_finder.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/objects/object_catalog.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kMeshes = fs::path(PICKBED_TEST_DATA) / "meshes";

struct RealMesh {
  const char* file;
  int triangles;
  bool watertight;
  double volume_m3;
  Eigen::Vector3d size_m;
};

class RealMeshes : public testing::TestWithParam<RealMesh> {};

TEST_P(RealMeshes, LoadWithExpectedMeasures) {
  const RealMesh& expected = GetParam();
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "no real meshes at " << kMeshes;
  const TriangleMesh mesh = LoadMesh(kMeshes / expected.file);
  const MeshReport report = InspectMesh(mesh);
  EXPECT_TRUE(report.finite);
  EXPECT_EQ(report.triangles, expected.triangles);
  EXPECT_EQ(report.watertight(), expected.watertight) << report.open_edges;
  EXPECT_NEAR(report.volume_m3, expected.volume_m3, 1e-3 * expected.volume_m3);
  EXPECT_LT((MeshBounds(mesh).size() - expected.size_m).cwiseAbs().maxCoeff(),
            1e-4 * expected.size_m.maxCoeff());
  EXPECT_NO_THROW(RequireUsableMesh(mesh, expected.file));
}

TEST_P(RealMeshes, SurviveARoundTrip) {
  const RealMesh& expected = GetParam();
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "no real meshes at " << kMeshes;
  const TemporaryFolder folder;
  const TriangleMesh mesh = LoadMesh(kMeshes / expected.file);
  SaveObj(folder.path() / "again.obj", mesh);
  const TriangleMesh again = LoadMesh(folder.path() / "again.obj");
  EXPECT_EQ(again.triangles.size(), mesh.triangles.size());
  // Vertices whose normals differ by less than the written digits become one.
  EXPECT_LE(again.vertices.size(), mesh.vertices.size());
  EXPECT_GE(again.vertices.size(), 0.999 * mesh.vertices.size());
  EXPECT_EQ(InspectMesh(again).watertight(), expected.watertight);
  EXPECT_NEAR(InspectMesh(again).volume_m3, expected.volume_m3, 1e-3 * expected.volume_m3);
}

TEST_P(RealMeshes, BecomeObjects) {
  const RealMesh& expected = GetParam();
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "no real meshes at " << kMeshes;
  MeshObjectSpec spec;
  spec.mesh = kMeshes / expected.file;
  spec.mass_kg = 0.25;
  const auto object = LoadMeshObject("part", spec);
  EXPECT_DOUBLE_EQ(object->mass.mass_kg, 0.25);
  EXPECT_NEAR(object->mass.volume_m3, expected.volume_m3, 1e-3 * expected.volume_m3);
  const Bounds bounds = MeshBounds(object->mesh_O);
  EXPECT_LE((bounds.min - object->mass.com_O).maxCoeff(), 0);
  EXPECT_LE((object->mass.com_O - bounds.max).maxCoeff(), 0);
  EXPECT_GE(object->diameter_m, bounds.size().maxCoeff() - 1e-12);
  EXPECT_LE(object->diameter_m, bounds.size().norm() + 1e-12);
}

// The thread of the nut shifts the centers of its half turns by 0.3 mm, so only the exact group has
// equal fractions of a turn.
TEST(RealSymmetries, ANutHasExactSixfoldRotationsAndFlips) {
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "no real meshes at " << kMeshes;
  const SymmetrySet found =
      FindSymmetries(LoadMesh(kMeshes / "industrial/factory_nut_m20_loose_subdiv_3x.obj"));
  ASSERT_EQ(found.discrete_O.size(), 11u);
  for (const Pose& S : found.discrete_O) {
    const double sixths = Eigen::AngleAxisd(S.linear()).angle() / (std::numbers::pi / 3);
    EXPECT_NEAR(sixths, std::round(sixths), 1e-9);
  }
}

// Sizes are stated by the sources (M16 bolt, 12 mm peg, cubes of side 2, ...). Volumes of the
// difficult cases are computed by hand: a box with a hole through it, an octahedron, a tetrahedron
// with a dent.
INSTANTIATE_TEST_SUITE_P(
    Table, RealMeshes,
    testing::Values(
        RealMesh{"traps/two_cube_objects.obj", 24, true, 16, {6, 2, 2}},
        RealMesh{"traps/quad_cube.obj", 12, true, 8, {2, 2, 2}},
        RealMesh{"traps/quad_cube.stl", 12, true, 8, {2, 2, 2}},
        RealMesh{"traps/octahedron.obj", 8, true, 8 * std::sqrt(2.0) / 3, {2, 2, 2.828427}},
        RealMesh{"traps/non_convex_mesh.obj", 6, true, 0.1, {1, 1, 1}},
        RealMesh{
            "traps/rotated_cube_squished.gltf", 12, true, 0.125, {1.707107, 0.426777, 0.707107}},
        RealMesh{"ycb/004_sugar_box_textured.obj",
                 16384,
                 true,
                 6.379e-4,
                 {0.049496, 0.094162, 0.176015}},
        RealMesh{"ycb/003_cracker_box_textured.gltf",
                 16384,
                 true,
                 2.1733e-3,
                 {0.0718, 0.213437, 0.164036}},
        RealMesh{"ycb/006_mustard_bottle_textured.obj",
                 16382,
                 true,
                 6.120e-4,
                 {0.097198, 0.066621, 0.191301}},
        RealMesh{"ycb/035_power_drill.obj", 15728, true, 5.800e-4, {0.162987, 0.123195, 0.187434}},
        RealMesh{
            "industrial/factory_bolt_m16_tight.obj", 25672, true, 1.1468e-5, {0.024, 0.024, 0.041}},
        RealMesh{"industrial/factory_nut_m20_loose_subdiv_3x.obj",
                 14870,
                 false,
                 7.946e-6,
                 {0.03, 0.034642, 0.016}},
        RealMesh{"industrial/industreal_gear_medium.obj",
                 35118,
                 true,
                 1.7842e-5,
                 {0.041914, 0.041914, 0.02}},
        RealMesh{"industrial/battery_collision.stl", 108, true, 2.6004e-4, {0.132, 0.05, 0.04}},
        RealMesh{"industrial/regulator_collision.stl", 528, true, 3.9765e-4, {0.1, 0.115, 0.07}}),
    [](const testing::TestParamInfo<RealMesh>& info) {
      std::string name = info.param.file;
      for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
      return name;
    });

TEST(RealMeshesCollada, ApplyScaleAndTranslationOfNodes) {
  const fs::path path = kMeshes / "industrial/bin_exterior.dae";
  if (!fs::exists(path)) GTEST_SKIP() << "no real mesh at " << path;
  const TriangleMesh bin = LoadMesh(path);  // inches, with a node scale of 0.0254
  EXPECT_TRUE(MeshBounds(bin).size().isApprox(Eigen::Vector3d(0.66836, 0.66836, 0.790893), 1e-4));
  // Its walls have zero thickness, so it is no object.
  InputErrorOf([&] { RequireUsableMesh(bin, path); });
}

TEST(RealMeshesHole, ARayPassesThrough) {
  const fs::path path = kMeshes / "traps/cube_with_hole.obj";
  if (!fs::exists(path)) GTEST_SKIP() << "no real mesh at " << path;
  const MeshQuery query(LoadMesh(path));
  int through = 0;
  for (int axis = 0; axis < 3; ++axis) {
    through += query.AllHits({0.01, 0.02, 0.03}, Eigen::Vector3d::Unit(axis)).empty();
  }
  EXPECT_EQ(through, 1);
}

}  // namespace
}  // namespace pickbed::tests
