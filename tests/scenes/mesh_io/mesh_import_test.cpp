#include "scenes/mesh_io/mesh_import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
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

TEST(ImportMesh, RefusesDamagedTextures) {
  const TemporaryFolder folder;
  Image<Rgb8> image(16, 16);
  const std::string png = EncodePng(image, 3), jpeg = EncodeJpeg(image, 90);
  struct {
    const char* file_name;
    std::string bytes, message;
  } const cases[] = {{"a.png", "not an image", "it is no image"},
                     {"b.png", png.substr(0, png.size() / 2), "the PNG is cut short"},
                     {"c.png", png + "x", "1 bytes after its end"},
                     {"d.jpg", jpeg.substr(0, jpeg.size() - 20), "the JPEG is damaged"},
                     {"e.JPG", "", "it is no image"},
                     {"f.bin", jpeg.substr(0, jpeg.size() - 20), "the JPEG is damaged"}};
  for (const auto& test : cases) {
    folder.Write(test.file_name, test.bytes);
    folder.Write("a.mtl", fmt::format("newmtl m\nmap_Kd {}\n", test.file_name));
    const std::string obj = folder.Write(
        "a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
    EXPECT_THAT(InputErrorOf([&] { ImportMesh(obj, 1); }),
                AllOf(HasSubstr(obj), HasSubstr(test.file_name), HasSubstr(test.message)))
        << test.file_name;
  }
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
