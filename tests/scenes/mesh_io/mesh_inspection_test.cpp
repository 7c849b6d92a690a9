#include "scenes/mesh_io/mesh_inspection.h"

#include <gmock/gmock.h>

#include "scenes/base/error.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class MeshInspection : public ::testing::Test {
 protected:
  std::filesystem::path Save(const TriangleMesh& mesh) {
    const auto file = folder_.path() / "part.obj";
    SaveObj(file, mesh);
    return file;
  }
  InspectedMesh Inspect(const TriangleMesh& mesh, const std::string& unit = "m") {
    return InspectMeshFile(Save(mesh), unit, false);
  }
  const TemporaryFolder folder_;
};

TEST(GuessUnit, PrefersTheSizeOfAPickableObject) {
  EXPECT_EQ(GuessUnit(0.12).unit, "m");
  EXPECT_EQ(GuessUnit(120).unit, "mm");
  EXPECT_EQ(GuessUnit(20).unit, "mm");
  // 4 m and 4 mm are no sizes of a pickable object; 4 in (10 cm) is nearer to one than 4 cm.
  EXPECT_EQ(GuessUnit(4).unit, "in");
  EXPECT_THAT(GuessUnit(120).reason, HasSubstr("120 mm"));
}

TEST_F(MeshInspection, SoundMeshHasNoNotes) {
  const InspectedMesh box = Inspect(BoxShape({0.1, 0.05, 0.02}));
  EXPECT_TRUE(box.watertight);
  EXPECT_EQ(box.shells, 1);
  EXPECT_THAT(box.fixed, IsEmpty());
  EXPECT_THAT(box.notes, IsEmpty());
}

TEST_F(MeshInspection, FindsPlantedFaults) {
  TriangleMesh inside_out = BoxShape({0.1, 0.05, 0.02});
  TurnInsideOut(inside_out);
  EXPECT_THAT(Inspect(inside_out).fixed, ElementsAre(HasSubstr("flipped outwards")));

  TriangleMesh open = BoxShape({0.1, 0.05, 0.02});
  open.triangles.pop_back();
  EXPECT_FALSE(Inspect(open).watertight);
  EXPECT_THAT(Inspect(open).notes, Contains(HasSubstr("open along 3 of its edges")));

  TriangleMesh two = BoxShape({0.1, 0.05, 0.02});
  Append(BoxShape({0.02, 0.02, 0.02}, {0, 0, 0.1}), two);
  EXPECT_EQ(Inspect(two).shells, 2);
  EXPECT_THAT(Inspect(two).notes, ElementsAre(HasSubstr("2 separate shells")));

  TriangleMesh degenerate = BoxShape({0.1, 0.05, 0.02});
  degenerate.triangles.emplace_back(3, 3, 4);
  EXPECT_THAT(Inspect(degenerate).fixed, ElementsAre(HasSubstr("1 faces had two corners")));

  TriangleMesh twice = BoxShape({0.1, 0.05, 0.02});
  Append(BoxShape({0.1, 0.05, 0.02}), twice);
  const InspectedMesh once = Inspect(twice);
  EXPECT_THAT(once.fixed, ElementsAre(HasSubstr("12 duplicate faces were removed")));
  EXPECT_NEAR(InspectMesh(once.mesh_O).volume_m3, 0.1 * 0.05 * 0.02, 1e-9);

  TriangleMesh odd_normals = BallShape(0.05, 2);
  odd_normals.normals[5].setZero();
  EXPECT_THAT(Inspect(odd_normals).fixed, ElementsAre(HasSubstr("normals")));
}

TEST_F(MeshInspection, FarOriginIsReportedAndMovedOnRequest) {
  const TriangleMesh far = BoxShape({0.1, 0.05, 0.02}, {1, 2, 0});
  EXPECT_THAT(Inspect(far).notes, ElementsAre(HasSubstr("centering")));
  const InspectedMesh moved = InspectMeshFile(Save(far), "m", true);
  EXPECT_LT(MeshBounds(moved.mesh_O).center().norm(), 1e-6);
  EXPECT_THAT(moved.fixed, ElementsAre(HasSubstr("moved there")));
  const TriangleMesh too_far = BoxShape({0.1, 0.05, 0.02}, {50, 0, 0});
  EXPECT_THROW(Inspect(too_far), InputError);
  EXPECT_LT(MeshBounds(InspectMeshFile(Save(too_far), "m", true).mesh_O).center().norm(), 1e-4);
}

TEST_F(MeshInspection, ListsMissingCompanionFiles) {
  const auto file = folder_.Write("lost.obj",
                                  "mtllib gone away.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                  "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_THAT(MissingCompanions(file), ElementsAre("gone away.mtl"));
  folder_.Write("gone away.mtl", "newmtl a\nmap_Kd C:\\pictures\\skin.png\n");
  EXPECT_THAT(MissingCompanions(file), ElementsAre("C:\\pictures\\skin.png"));
  folder_.Write("skin.png", "anything");
  EXPECT_THAT(MissingCompanions(file), IsEmpty());
  EXPECT_THAT(InspectMeshFile(file, "cm", false).notes, IsEmpty());
}

TEST_F(MeshInspection, RefusesMeshesThatAreNoObject) {
  const TriangleMesh box = BoxShape({1, 1, 1});
  EXPECT_THAT(InputErrorOf([&] { Inspect(Scaled(box, 1e6)); }), HasSubstr("check the unit"));
  EXPECT_THAT(InputErrorOf([&] { Inspect(box, "mm"); }), HasSubstr("0.00173 m large"));
  const auto words = folder_.Write("words.stl", "this is not a mesh");
  EXPECT_THAT(InputErrorOf([&] { InspectMeshFile(words, "m", false); }), HasSubstr("words.stl"));
}

}  // namespace
}  // namespace pickbed::tests
