#include "scenes/mesh_io/mesh_import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

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

// The importer takes 0 in place of a texture coordinate of an OBJ that is not a number.
TEST(ImportMesh, RefusesFarTextureCoordinates) {
  const TemporaryFolder folder;
  const auto with = [&](const char* coordinate) {
    return folder.Write(
        "a.obj", fmt::format("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt {} 0\nf 1/1 2/1 3/1\n", coordinate));
  };
  for (const char* coordinate : {"-4000.5", "nan"})
    EXPECT_NO_THROW(ImportMesh(with(coordinate), 1));
  for (const char* coordinate : {"1e300", "-inf", "9223372036854775808"}) {
    EXPECT_THAT(InputErrorOf([&] { ImportMesh(with(coordinate), 1); }),
                HasSubstr(fmt::format("line 4 has the texture coordinate '{}'", coordinate)));
  }
}

// Writes a triangle with this texture coordinate, and with a texture if it has a name.
std::string WriteTexturedGltf(const TemporaryFolder& folder, float coordinate,
                              const std::string& texture) {
  const float vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, uvs[] = {0, 0, 1, coordinate, 0, 1};
  std::string bytes(reinterpret_cast<const char*>(vertices), sizeof vertices);
  bytes.append(reinterpret_cast<const char*>(uvs), sizeof uvs);
  folder.Write("a.bin", bytes);
  const std::string image = texture.empty() ? "" : R"(,"images":[{"uri":"a.png"}],
"textures":[{"source":0}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])";
  return folder.Write("a.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1})" +
                                    std::string(image.empty() ? "" : R"(,"material":0)") + R"(}]}],
"buffers":[{"uri":"a.bin","byteLength":60}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
"min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}])" +
                                    image + "}");
}

TEST(ImportMesh, RefusesTextureCoordinatesThatAreNone) {
  const TemporaryFolder folder;
  folder.Write("a.png", EncodePng(Image<Rgb8>(4, 4), 3));
  const auto error = [&](float coordinate, const std::string& texture) {
    const std::string file = WriteTexturedGltf(folder, coordinate, texture);
    return InputErrorOf([&] {
      ImportMesh(file, 1);
      throw InputError("accepted");
    });
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const char* texture : {"a.png", ""}) {
    EXPECT_EQ(error(-4000.5f, texture), "accepted");
    EXPECT_THAT(error(1e30f, texture), HasSubstr("a.gltf' has the texture coordinate"));
  }
  EXPECT_EQ(error(nan, ""), "accepted");
  EXPECT_THAT(error(nan, "a.png"), HasSubstr("a.gltf' has a texture coordinate that is no number"));
}

// Writes a tetrahedron with these indices as the corners of its faces.
std::string WriteGltf(const TemporaryFolder& folder, const std::vector<uint16_t>& corners) {
  const float vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::string bytes(reinterpret_cast<const char*>(vertices), sizeof vertices);
  bytes.append(reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(uint16_t));
  folder.Write("a.bin", bytes);
  return folder.Write("a.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"buffers":[{"uri":"a.bin","byteLength":72}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},
{"buffer":0,"byteOffset":48,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
"min":[0,0,0],"max":[1,1,1]},
{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})");
}

// The importer drops such faces with a warning.
TEST(ImportMesh, AGltfWithAnIndexWithoutVertexIsNotLoadedInPart) {
  const TemporaryFolder folder;
  const std::string file = WriteGltf(folder, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3});
  EXPECT_EQ(ImportMesh(file, 1).mesh.triangles.size(), 4u);
  for (const uint16_t index : {uint16_t{4}, uint16_t{60000}}) {
    WriteGltf(folder, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, index});
    EXPECT_THAT(InputErrorOf([&] { ImportMesh(file, 1); }),
                AllOf(HasSubstr(file), HasSubstr("out-of-range indices")))
        << index;
  }
}

TEST(ImportMesh, TheLimitOfCoordinatesIsInTheUnitOfTheFile) {
  const TemporaryFolder folder;
  const auto triangle = [&](const char* x) {
    return folder.Write("a.obj", fmt::format("v 0 0 0\nv {} 0 0\nv 0 1 0\nf 1 2 3\n", x));
  };
  for (const double scale : {1e-6, 1e-3, 1.0, 10.0}) {
    EXPECT_NEAR(MeshBounds(ImportMesh(triangle("9e6"), scale).mesh).max.x(), 9e6 * scale,
                9e6 * scale * 1e-6);
    EXPECT_THAT(InputErrorOf([&] { ImportMesh(triangle("1.1e7"), scale); }),
                HasSubstr("a coordinate over 1e+07"))
        << scale;
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
