#include "scenes/objects/object_catalog.h"

#include <gmock/gmock.h>

#include <numbers>

#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

const Vector3d kSize(0.06, 0.04, 0.02);

// Writes a folder `name` with a box of kSize in millimetres at (10, 0, 0) and the given
// object.yaml.
void AddObject(const TemporaryFolder& root, const std::string& name, const std::string& yaml) {
  root.Write(name + "/object.yaml", yaml);
  SaveObj(root.path() / name / "mesh.obj", BoxShape(1e3 * kSize, {10, 0, 0}));
}

TEST(ObjectCatalog, RefusesACenterOfMassWithoutInertiaOrOutsideOfTheMesh) {
  const TemporaryFolder root;
  const auto error_of = [&](const std::string& mass) {
    AddObject(root, "block", "mesh: mesh.obj\nunit: mm\nmass_kg: 0.5\nfriction: 0.4\n" + mass);
    return ErrorOf([&] { ObjectCatalog({root.path()}).Load("block"); });
  };
  const std::string com = "com_m: [0.01, 0, 0]\n", far = "com_m: [0.2, 0, 0]\n";
  const std::string inertia = "inertia_diagonal_kgm2: [0.0001, 0.0002, 0.0002]\n";
  EXPECT_EQ(error_of(com + inertia), "no error");
  EXPECT_THAT(error_of(com), HasSubstr("need inertia_diagonal_kgm2"));
  EXPECT_THAT(error_of("inertia_products_kgm2: [1e-6, 0, 0]\n"),
              HasSubstr("need inertia_diagonal_kgm2"));
  EXPECT_THAT(error_of(far + inertia), HasSubstr("object.yaml: no solid within the mesh"));
  // One moment is larger than the sum of the others.
  EXPECT_THAT(error_of(com + "inertia_diagonal_kgm2: [0.0001, 0.0005, 0.0002]\n"),
              HasSubstr("no solid within the mesh"));
}

TEST(ObjectCatalog, LoadsAllFieldsOfTheFile) {
  const TemporaryFolder root;
  AddObject(
      root, "block",
      "mesh: mesh.obj\nunit: mm\ndensity_kgpm3: 2700\nfriction: 0.4\nconvex: convex.obj\n"
      "symmetries:\n  discrete:\n    - {axis: [0, 0, 2], angle_deg: 180, offset_m: [0.01, 0, 0]}\n"
      "  continuous:\n    - {axis: [3, 0, 0], offset_m: [0, 0.5, 0]}\n");
  root.Write("block/convex.obj", "o a\nv 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\n");
  const auto block = ObjectCatalog({root.path()}).Load("block");
  EXPECT_EQ(block->name, "block");
  EXPECT_NEAR(block->mass.mass_kg, 2700 * kSize.prod(), 1e-7);
  EXPECT_LT((block->mass.com_O - Vector3d(0.01, 0, 0)).norm(), 1e-8);  // O is not moved
  EXPECT_NEAR(block->mass.inertia_com_O(0, 0),
              block->mass.mass_kg / 12 * (0.04 * 0.04 + 0.02 * 0.02), 1e-10);
  EXPECT_EQ(block->friction, 0.4);
  EXPECT_NEAR(block->diameter_m, kSize.norm(), 1e-8);
  EXPECT_EQ(block->mesh_hash, MeshHash(block->mesh_O));
  ASSERT_EQ(block->convex_pieces_O.size(), 1u);
  EXPECT_TRUE(block->convex_pieces_O[0].vertices_O[1].isApprox(Vector3d(0.01, 0, 0)));
  ASSERT_EQ(block->symmetries_O.discrete_O.size(), 1u);
  const Pose& flip = block->symmetries_O.discrete_O[0];
  EXPECT_TRUE((flip * Vector3d(0.04, 0.02, 0.01)).isApprox(Vector3d(-0.02, -0.02, 0.01), 1e-9));
  ASSERT_EQ(block->symmetries_O.continuous_O.size(), 1u);
  EXPECT_TRUE(block->symmetries_O.continuous_O[0].axis_O.isApprox(Vector3d::UnitX()));
  EXPECT_TRUE(block->symmetries_O.continuous_O[0].offset_O.isApprox(Vector3d(0, 0.5, 0)));
}

TEST(ObjectCatalog, EarlierFoldersHavePriorityAndMissingOnesAreEmpty) {
  const TemporaryFolder mine, shipped;
  AddObject(mine, "block", "unit: mm\nmass_kg: 1\n");
  AddObject(shipped, "block", "unit: mm\nmass_kg: 2\n");
  AddObject(shipped, "anvil", "unit: mm\nmass_kg: 3\n");
  shipped.Write("notes/readme.txt", "no object");
  const ObjectCatalog catalog({mine.path() / "none", mine.path(), shipped.path()});
  EXPECT_THAT(catalog.Names(), ElementsAre("anvil", "block"));
  EXPECT_EQ(catalog.Load("block")->mass.mass_kg, 1);
  EXPECT_EQ(catalog.Load("anvil")->mass.mass_kg, 3);
}

TEST(ObjectCatalog, SuggestsNamesForUnknownObjects) {
  const TemporaryFolder root;
  AddObject(root, "bracket", "unit: mm\nmass_kg: 1\n");
  const ObjectCatalog catalog({root.path()});
  EXPECT_EQ(InputErrorOf([&] { catalog.Load("brakcet"); }),
            "unknown object 'brakcet'; did you mean 'bracket'? known: bracket");
  InputErrorOf([&] { catalog.Load("../" + root.path().filename().string() + "/bracket"); });
  InputErrorOf([&] { catalog.Load(""); });
}

TEST(ObjectCatalog, ErrorsHoldFileAndKey) {
  const TemporaryFolder root;
  struct {
    const char* yaml;
    const char* message;
  } cases[] = {
      {"unit: mm\n", "exactly one of mass_kg and density_kgpm3"},
      {"unit: mm\nmass_kg: 1\ndensity_kgpm3: 2\n", "exactly one of"},
      {"unit: mm\nmass_kg: -1\n", "mass_kg"},
      {"unit: feet\nmass_kg: 1\n", "feet"},
      {"unit: mm\nmass_kg: 1\nfricton: 1\n", "friction"},
      {"unit: mm\nmass_kg: 1\nmesh: none.obj\n", "none.obj"},
      {"unit: mm\nmass_kg: 1\nconvex: none.obj\n", "none.obj"},
      {"unit: mm\nmass_kg: 1\nsymmetries: {continuous: [{axis: [0, 0, 0]}]}\n", "axis must not"},
      {"unit: mm\nmass_kg: 1\nsymmetries: {discrete: [{axis: [0, 0, 1]}]}\n", "angle_deg must not"},
      {"unit: mm\nmass_kg: 1\nsymmetries: {discrete: [{angle_deg: 90}]}\n", "axis must not"},
  };
  for (const auto& c : cases) {
    AddObject(root, "block", c.yaml);
    const std::string message = InputErrorOf([&] { ObjectCatalog({root.path()}).Load("block"); });
    EXPECT_THAT(message, HasSubstr(c.message)) << c.yaml;
    EXPECT_THAT(message, HasSubstr("block/")) << c.yaml;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

MeshObjectSpec SpecOf(const fs::path& mesh) {
  MeshObjectSpec spec;
  spec.mesh = mesh;
  spec.mass_kg = 0.5;
  return spec;
}

TEST(LoadMeshObject, AppliesUnitAndMass) {
  const TemporaryFolder folder;
  SaveObj(folder.path() / "box.obj", BoxShape(1e3 * kSize));
  MeshObjectSpec spec = SpecOf(folder.path() / "box.obj");
  spec.unit = "mm";
  spec.friction = 0.8;
  spec.symmetries_O.continuous_O.push_back({});
  const auto object = LoadMeshObject("box", spec);
  EXPECT_EQ(object->name, "box");
  EXPECT_NEAR(object->mass.volume_m3, kSize.prod(), 1e-12);
  EXPECT_EQ(object->mass.mass_kg, 0.5);
  EXPECT_NEAR(object->mass.inertia_com_O(2, 2), 0.5 / 12 * (0.06 * 0.06 + 0.04 * 0.04), 1e-10);
  EXPECT_EQ(object->friction, 0.8);
  EXPECT_EQ(object->symmetries_O.continuous_O.size(), 1u);
  EXPECT_TRUE(object->convex_pieces_O.empty());
}

TEST(LoadMeshObject, TurnsInsideOutMeshesOutwards) {
  const TemporaryFolder folder;
  TriangleMesh inside_out = BallShape(0.05, 3);
  TurnInsideOut(inside_out);
  SaveObj(folder.path() / "ball.obj", inside_out);
  const auto object = LoadMeshObject("ball", SpecOf(folder.path() / "ball.obj"));
  EXPECT_GT(InspectMesh(object->mesh_O).volume_m3, 0);
  EXPECT_NEAR(object->mass.com_O.norm(), 0, 1e-7);
}

// A small hole in a scan changes the volume by less than 2 %.
TEST(LoadMeshObject, ToleratesASmallHole) {
  const TemporaryFolder folder;
  TriangleMesh ball = BallShape(0.05, 4);
  const double volume = InspectMesh(ball).volume_m3;
  ball.triangles.resize(ball.triangles.size() - 8);
  SaveObj(folder.path() / "scan.obj", ball);
  const auto scan = LoadMeshObject("scan", SpecOf(folder.path() / "scan.obj"));
  EXPECT_FALSE(InspectMesh(scan->mesh_O).watertight());
  EXPECT_NEAR(scan->mass.volume_m3, volume, 0.02 * volume);
  EXPECT_LT(scan->mass.com_O.norm(), 0.002);
}

// Two opposite sides of a box enclose no valid solid, so the mass properties of the bounding box
// are used.
TEST(LoadMeshObject, UsesTheBoundingBoxOfAnInvalidSolid) {
  const TemporaryFolder folder;
  TriangleMesh sides = BoxShape(kSize);
  sides.triangles.erase(sides.triangles.begin() + 4, sides.triangles.end());
  sides.triangles.insert(sides.triangles.end(), sides.triangles.begin(), sides.triangles.end());
  sides.triangles.insert(sides.triangles.end(), sides.triangles.begin(), sides.triangles.end());
  SaveObj(folder.path() / "sides.obj", sides);
  const auto object = LoadMeshObject("sides", SpecOf(folder.path() / "sides.obj"));
  EXPECT_NEAR(object->mass.volume_m3, kSize.prod(), 1e-9);
  EXPECT_NEAR(object->mass.inertia_com_O(0, 0), 0.5 / 12 * (0.04 * 0.04 + 0.02 * 0.02), 1e-9);
}

TEST(LoadMeshObject, RefusesInvalidMeshesMassesAndFrictions) {
  const TemporaryFolder folder;
  const fs::path good = folder.path() / "good.obj";
  SaveObj(good, BoxShape(kSize));
  const auto error_of = [](const MeshObjectSpec& spec) {
    return InputErrorOf([&] { LoadMeshObject("p", spec); });
  };
  EXPECT_THAT(error_of(SpecOf(folder.path() / "none.obj")), HasSubstr("none.obj' does not exist"));
  const fs::path flat = folder.Write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(error_of(SpecOf(flat)), HasSubstr("flat.obj' encloses no volume"));
  const fs::path points = folder.Write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
  EXPECT_THAT(error_of(SpecOf(points)), HasSubstr("no faces"));
  const fs::path nan = folder.Write(
      "nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_THAT(error_of(SpecOf(nan)), HasSubstr("nan.obj"));
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    MeshObjectSpec mass = SpecOf(good), friction = SpecOf(good);
    mass.mass_kg = bad;
    friction.friction = bad;
    EXPECT_THAT(error_of(mass), HasSubstr("mass_kg"));
    EXPECT_THAT(error_of(friction), HasSubstr("friction"));
  }
  MeshObjectSpec unit = SpecOf(good);
  unit.unit = "yard";
  EXPECT_THAT(error_of(unit), HasSubstr("unknown unit 'yard'"));
}

}  // namespace
}  // namespace pickbed::tests
