#include "scenes/mesh_io/mesh_import.h"

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_file_check.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(ImportMesh, NotesTheFilesThatItLookedFor) {
  const TemporaryFolder folder;
  const std::string obj =
      folder.Write("a.obj",
                   "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                   "usemtl red\nf 1/1 2/2 3/3\n");
  folder.Write("a.mtl", "newmtl red\nKd 1 0 0\nmap_Kd missing.png\n");
  const ImportedMesh imported = ImportMesh(obj, 2);
  EXPECT_EQ(imported.mesh.vertices.size(), 3u);
  EXPECT_DOUBLE_EQ(MeshBounds(imported.mesh).max.x(), 2);
  EXPECT_TRUE(imported.used.contains(folder.path() / "a.mtl"));
  EXPECT_TRUE(imported.used.contains(folder.path() / "missing.png"));
  EXPECT_FALSE(imported.used.contains(obj));
}

TEST(MeshFileCheck, ReadsTheFaceCountOfAPlyHeader) {
  const TemporaryFolder folder;
  const std::string header = "ply\nformat ascii 1.0\nelement vertex 3\nelement face 2\n";
  EXPECT_EQ(FacesInHeader(folder.Write("a.ply", header + "end_header\n1\n2\n3\n4\n5\n")), 2u);
  EXPECT_EQ(FacesInHeader(folder.Write("a.obj", "f 1 2 3\n")), 0u);
  EXPECT_THAT(InputErrorOf([&] { CheckMeshFile(folder.Write("b.ply", header)); }),
              HasSubstr("without end"));
  EXPECT_THAT(InputErrorOf([&] { CheckMeshFile(folder.Write("c.stl", "solid x\nfacet\n")); }),
              HasSubstr("cut short"));
  CheckMeshFile(folder.Write("d.stl", "solid x\nfacet\nENDSOLID\n"));
}

}  // namespace
}  // namespace pickbed::tests
