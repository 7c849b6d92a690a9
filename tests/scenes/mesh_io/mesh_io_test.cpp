#include "scenes/mesh_io/mesh_io.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>
#include <fstream>

#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

std::string Base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    }
    for (size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

template <typename T>
void AppendBytes(T value, std::string& bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

// Returns glTF text of a triangle with corners (0,0,0), (1,0,0), (0,1,0), normal z and uvs equal to
// x and y, with the given node member (such as a matrix) and image.
std::string TriangleGltf(const std::string& node, const std::string& image_uri = "") {
  std::string buffer;
  for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0}) AppendBytes(x, buffer);
  for (int i = 0; i < 3; ++i) {
    for (const float x : {0, 0, 1}) AppendBytes(x, buffer);
  }
  for (const float x : {0.f, 0.f, 1.f, 0.f, 0.f, 1.f}) AppendBytes(x, buffer);
  for (const uint16_t i : {0, 1, 2}) AppendBytes(i, buffer);
  const std::string texture = image_uri.empty() ? "" : R"("baseColorTexture": {"index": 0}, )";
  const std::string images =
      image_uri.empty()
          ? ""
          : fmt::format(R"("images": [{{"uri": "{}"}}], "textures": [{{"source": 0}}],)",
                        image_uri);
  return fmt::format(
      R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
"nodes": [{{"mesh": 0{}}}], {}
"materials": [{{"pbrMetallicRoughness": {{{}"baseColorFactor": [0.2, 0.4, 0.6, 1]}}}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}},
"indices": 3, "material": 0}}]}}],
"accessors": [
{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
  "min": [0, 0, 0], "max": [1, 1, 0]}},
{{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}},
{{"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"}},
{{"bufferView": 3, "componentType": 5123, "count": 3, "type": "SCALAR"}}],
"bufferViews": [
{{"buffer": 0, "byteOffset": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 36}},
{{"buffer": 0, "byteOffset": 72, "byteLength": 24}}, {{"buffer": 0, "byteOffset": 96, "byteLength": 6}}],
"buffers": [{{"byteLength": {}, "uri": "data:application/octet-stream;base64,{}"}}]}})",
      node, images, texture, buffer.size(), Base64(buffer));
}

constexpr char kCubeObj[] =
    "v 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv -1 -1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\nv -1 1 -1\n"
    "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 5 1 4 8\n";

TEST(UnitInMeters, KnowsOnlyTheListedUnits) {
  EXPECT_EQ(UnitInMeters("m"), 1);
  EXPECT_EQ(UnitInMeters("cm"), 0.01);
  EXPECT_EQ(UnitInMeters("mm"), 0.001);
  EXPECT_EQ(UnitInMeters("in"), 0.0254);
  EXPECT_THAT(InputErrorOf([] { UnitInMeters("furlong"); }),
              testing::AllOf(HasSubstr("'furlong'"), HasSubstr("m, cm, mm, in")));
}

TEST(LoadMesh, SplitsQuadsScalesAndJoinsCorners) {
  const TemporaryFolder folder;
  const auto path = folder.Write("cube.obj", kCubeObj);
  const TriangleMesh cube = LoadMesh(path, "mm");
  EXPECT_EQ(cube.vertices.size(), 8u);
  EXPECT_EQ(cube.triangles.size(), 12u);
  EXPECT_NEAR(InspectMesh(cube).volume_m3, 8e-9, 1e-15);
  EXPECT_TRUE(cube.normals.empty());
  EXPECT_EQ(cube.base_color, TriangleMesh().base_color);
}

TEST(LoadMesh, ReadsEveryObjectOfAFile) {
  const TemporaryFolder folder;
  const auto path = folder.Write(
      "two.obj", std::string("o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
                             "f 2 3 4\no b\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf 5 7 6\nf 5 6 8\n"
                             "f 5 8 7\nf 6 7 8\n"));
  const TriangleMesh two = LoadMesh(path);
  EXPECT_EQ(two.triangles.size(), 8u);
  EXPECT_NEAR(InspectMesh(two).volume_m3, 2.0 / 6, 1e-6);
  EXPECT_NEAR(MeshBounds(two).max.x(), 6, 1e-6);
}

TEST(LoadMesh, KeepsDetailBelowTenMicrometers) {
  const TemporaryFolder folder;
  const auto path = folder.Write("tiny.obj",
                                 "v 0 0 0\nv 4e-6 0 0\nv 0 4e-6 0\nv 0 0 4e-6\nf 1 3 2\nf 1 2 4\n"
                                 "f 1 4 3\nf 2 3 4\n");
  EXPECT_EQ(LoadMesh(path).vertices.size(), 4u);
}

TEST(LoadMesh, DropsCollapsedFacesAndUnusedVertices) {
  const TemporaryFolder folder;
  const auto path = folder.Write(
      "mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nv 1 0 0\nf 1 2 3\nf 1 1 2\nf 2 5 3\n");
  const TriangleMesh mesh = LoadMesh(path);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.vertices.size(), 3u);
}

TEST(LoadMesh, DropsFlatNormalsAndKeepsSmoothNormals) {
  const TemporaryFolder folder;
  SaveObj(folder.path() / "ball.obj", BallShape(0.05, 3));
  EXPECT_EQ(LoadMesh(folder.path() / "ball.obj").normals.size(),
            BallShape(0.05, 3).vertices.size());
  std::string flat = kCubeObj;
  flat = flat.substr(0, flat.find("f ")) +
         "vn 0 -1 0\nvn 0 1 0\nvn 1 0 0\nvn 0 0 1\nvn -1 0 0\nvn 0 0 -1\n"
         "f 1//1 2//1 3//1 4//1\nf 5//2 8//2 7//2 6//2\nf 1//3 5//3 6//3 2//3\n"
         "f 2//4 6//4 7//4 3//4\nf 3//5 7//5 8//5 4//5\nf 5//6 1//6 4//6 8//6\n";
  const TriangleMesh cube = LoadMesh(folder.Write("flat.obj", flat));
  EXPECT_TRUE(cube.normals.empty());
  EXPECT_EQ(cube.vertices.size(), 8u);
}

TEST(LoadMesh, AppliesNodeTransformsToPositionsAndNormals) {
  const TemporaryFolder folder;
  // The matrix scales x, shears y by x and translates. Normals of z = const planes stay along z.
  const auto path = folder.Write(
      "t.gltf",
      TriangleGltf(R"(, "matrix": [0.5, 1, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 10, 20, 30, 1])"));
  const TriangleMesh mesh = LoadMesh(path);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  const Eigen::Vector3i& t = mesh.triangles[0];
  EXPECT_TRUE(mesh.vertices[t[0]].isApprox(Vector3d(10, 20, 30), 1e-6));
  EXPECT_TRUE(mesh.vertices[t[1]].isApprox(Vector3d(10.5, 21, 30), 1e-6));
  EXPECT_TRUE(mesh.vertices[t[2]].isApprox(Vector3d(10, 21, 30), 1e-6));
  EXPECT_EQ(mesh.base_color, (Rgb8{51, 102, 153}));
}

TEST(LoadMesh, KeepsFacesOutwardsUnderAReflection) {
  const TemporaryFolder folder;
  const TriangleMesh mesh =
      LoadMesh(folder.Write("m.gltf", TriangleGltf(R"(, "scale": [-1, 1, 1])")));
  // The reflected surface still faces +z.
  EXPECT_GT(FaceNormals(mesh)[0].z(), 0.99);
  EXPECT_TRUE(mesh.normals.empty());  // dropped, because they equal the face normal
  const TriangleMesh upside_down =
      LoadMesh(folder.Write("n.gltf", TriangleGltf(R"(, "scale": [1, 1, -1])")));
  EXPECT_LT(FaceNormals(upside_down)[0].z(), -0.99);
  EXPECT_TRUE(upside_down.normals.empty());
}

// The normals of a ball with nonuniform scale are the normals of the ellipsoid, not of the ball.
TEST(LoadMesh, TransformsNormalsByTheInverseTranspose) {
  const TemporaryFolder folder;
  const TriangleMesh ball = BallShape(1, 4);
  std::string sources[2];
  for (size_t i = 0; i < ball.vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      sources[0] += fmt::format("{} ", ball.vertices[i][k]);
      sources[1] += fmt::format("{} ", ball.normals[i][k]);
    }
  }
  std::string faces;
  for (const auto& t : ball.triangles) faces += fmt::format("{} {} {} ", t[0], t[1], t[2]);
  const size_t n = ball.vertices.size();
  const auto source = [&](const char* id, const std::string& numbers) {
    return fmt::format(
        R"(<source id="{0}"><float_array id="{0}-array" count="{1}">{2}</float_array>
<technique_common><accessor source="#{0}-array" count="{3}" stride="3"><param name="X"
type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>)",
        id, 3 * n, numbers, n);
  };
  const std::string dae = fmt::format(
      R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>{}{}<vertices id="v"><input semantic="POSITION"
source="#p"/></vertices><triangles count="{}"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="0"/><p>{}</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="a"><matrix>
1 0 0 0 0 2 0 0 0 0 0.25 100 0 0 0 1</matrix><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
      source("p", sources[0]), source("n", sources[1]), ball.triangles.size(), faces);
  const TriangleMesh mesh = LoadMesh(folder.Write("ball.dae", dae));
  // The file's unit (centimetres) is applied, its up axis is not.
  EXPECT_TRUE(MeshBounds(mesh).size().isApprox(Vector3d(0.02, 0.04, 0.005), 1e-5));
  EXPECT_TRUE(MeshBounds(mesh).center().isApprox(Vector3d(0, 0, 1), 1e-5));
  ASSERT_EQ(mesh.normals.size(), mesh.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d axes(0.01, 0.02, 0.0025);
    const Vector3d gradient =
        (mesh.vertices[i] - Vector3d(0, 0, 1)).cwiseQuotient(axes.cwiseAbs2()).normalized();
    EXPECT_LT((mesh.normals[i] - gradient).norm(), 1e-3);
  }
}

TEST(LoadMesh, LoadsTexturesWithVZeroAtTheTopRow) {
  const TemporaryFolder folder;
  WritePng(folder.path() / "four.png", FourColors());
  folder.Write("quad.mtl", "newmtl m\nKd 1 1 1\nmap_Kd C:\\somewhere\\else\\four.png\n");
  const TriangleMesh obj = LoadMesh(
      folder.Write("quad.obj",
                   "mtllib quad.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
                   "f 1/1 2/2 3/3\n"));
  EXPECT_EQ(obj.texture, FourColors());
  ASSERT_EQ(obj.uvs.size(), 3u);
  EXPECT_TRUE(obj.uvs[0].isApprox(Eigen::Vector2d(0, 1)));  // OBJ's v = 0 is the bottom row
  const TriangleMesh external = LoadMesh(folder.Write("t.gltf", TriangleGltf("", "four.png")));
  const std::string png = Base64(ReadFileBytes(folder.path() / "four.png"));
  const TriangleMesh embedded =
      LoadMesh(folder.Write("e.gltf", TriangleGltf("", "data:image/png;base64," + png)));
  for (const TriangleMesh& gltf : {external, embedded}) {
    EXPECT_EQ(gltf.texture, FourColors());
    ASSERT_EQ(gltf.uvs.size(), 3u);
    EXPECT_TRUE(gltf.uvs[0].isZero(1e-6));  // glTF's v = 0 is the top row
  }
}

TEST(LoadMesh, MissingTexturesAndMaterialsAreIgnored) {
  const TemporaryFolder folder;
  const char* kFaces =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";
  folder.Write("with.mtl", "newmtl m\nKd 1 0 0\nmap_Kd none.png\n");
  folder.Write("other.mtl", "newmtl m\nmap_Kd other.tga\n");
  folder.Write("other.tga", "of a format that cannot be read");
  struct {
    const char* library;
    Rgb8 color;
  } cases[] = {{"with.mtl", {255, 0, 0}},
               {"none.mtl", TriangleMesh().base_color},
               {"other.mtl", TriangleMesh().base_color}};
  for (const auto& c : cases) {
    const TriangleMesh mesh =
        LoadMesh(folder.Write("m.obj", fmt::format("mtllib {}\n{}", c.library, kFaces)));
    EXPECT_EQ(mesh.triangles.size(), 1u) << c.library;
    EXPECT_TRUE(mesh.texture.empty() && mesh.uvs.empty()) << c.library;
    EXPECT_EQ(mesh.base_color, c.color) << c.library;
  }
}

TEST(LoadMesh, ConvertsSeveralTexturesToVertexColors) {
  const TemporaryFolder folder;
  WritePng(folder.path() / "a.png", FourColors());
  WritePng(folder.path() / "b.png", Image<Rgb8>(2, 2, {1, 2, 3}));
  folder.Write("m.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nKd 0 0 1\n");
  const TriangleMesh mesh = LoadMesh(folder.Write(
      "m.obj",
      "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0.25 0.75\nvt 0.75 0.75\nvt 0.25 0.25\n"
      "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 4/3\nusemtl c\nf 2 3 4\n"));
  EXPECT_TRUE(mesh.texture.empty() && mesh.uvs.empty());
  ASSERT_EQ(mesh.colors.size(), mesh.vertices.size());
  EXPECT_THAT(mesh.colors, testing::IsSupersetOf(
                               {Rgb8{250, 0, 0}, Rgb8{0, 250, 0}, Rgb8{0, 0, 250}, Rgb8{1, 2, 3}}));
}

TEST(LoadMesh, ReadsAsciiStlAndPly) {
  const TemporaryFolder folder;
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3});
  std::string stl = "solid box\n";
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      box.vertices.size(), box.triangles.size());
  for (const Vector3d& v : box.vertices)
    ply += fmt::format("{} {} {} 10 20 30\n", v.x(), v.y(), v.z());
  for (const Eigen::Vector3i& t : box.triangles) {
    ply += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    stl += "facet normal 0 0 0\nouter loop\n";  // some exporters write zero normals
    for (const int i : t) {
      stl += fmt::format("vertex {} {} {}\n", box.vertices[i].x(), box.vertices[i].y(),
                         box.vertices[i].z());
    }
    stl += "endloop\nendfacet\n";
  }
  stl += "endsolid box\n";
  for (const TriangleMesh& mesh :
       {LoadMesh(folder.Write("box.STL", stl)), LoadMesh(folder.Write("box.ply", ply))}) {
    EXPECT_EQ(mesh.vertices.size(), 8u);
    EXPECT_TRUE(mesh.normals.empty());
    EXPECT_NEAR(InspectMesh(mesh).volume_m3, 0.006, 1e-8);
    EXPECT_TRUE(InspectMesh(mesh).watertight());
  }
  EXPECT_EQ(LoadMesh(folder.path() / "box.ply").colors.at(7), (Rgb8{10, 20, 30}));
  EXPECT_EQ(LoadMesh(folder.path() / "box.STL").base_color, TriangleMesh().base_color);
}

// The number of faces is in the header or follows from the file size, so no face is read.
TEST(LoadMesh, RefusesTooManyFacesBeforeReadingThem) {
  const TemporaryFolder folder;
  const auto ply = [](size_t faces) {
    return fmt::format(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
        "y\nproperty float z\nelement face {}\nproperty list uchar int "
        "vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        faces);
  };
  const std::string many = folder.Write("many.ply", ply(kMaxMeshFaces + 1));
  const std::string message = InputErrorOf([&] { LoadMesh(many); });
  EXPECT_THAT(message, HasSubstr(many + "' has 1000001 faces; reduce it to 1000000 or fewer"));
  EXPECT_EQ(LoadMesh(folder.Write("one.ply", ply(1))).triangles.size(), 1u);

  const std::string stl = folder.path() / "many.stl";
  const uint32_t faces = kMaxMeshFaces + 1;
  {
    std::ofstream file(stl, std::ios::binary);
    file.write(std::string(80, ' ').data(), 80);
    file.write(reinterpret_cast<const char*>(&faces), 4);
  }
  std::filesystem::resize_file(stl, 84 + 50ull * faces);
  EXPECT_THAT(InputErrorOf([&] { LoadMesh(stl); }), HasSubstr("has 1000001 faces"));
}

// The number of faces of an OBJ file is known only after it is read.
TEST(LoadMesh, RefusesTooManyFacesOfAnObj) {
  const TemporaryFolder folder;
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  for (size_t i = 0; i < kMaxMeshFaces / 2 + 1; ++i) obj += "f 1 2 3 4\n";  // two triangles each
  EXPECT_THAT(InputErrorOf([&] { LoadMesh(folder.Write("many.obj", obj)); }),
              HasSubstr("has 1000002 faces"));
}

TEST(LoadMesh, RefusesFilesThatAreNoMesh) {
  const TemporaryFolder folder;
  struct {
    std::string path;
    const char* text;
  } cases[] = {
      {folder.path() / "none.obj", "does not exist"},
      {folder.path(), "does not exist"},
      {folder.Write("empty.obj", ""), "cannot read mesh"},
      {folder.Write("text.txt", "hello"), "text.txt\"; check that"},
      {folder.Write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"), "no faces"},
      {folder.Write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), "without area"},
      {folder.Write("broken.gltf", "{\"asset\": "), "cannot read mesh"},
      {folder.Write("half.ply", "ply\nformat ascii 1.0\nelement vertex 3\n"), "without end"},
      {folder.Write("obj_in.stl", kCubeObj), "its extension matches its format"},
      {folder.Write("obj_in.ply", kCubeObj), "its extension matches its format"},
  };
  for (const auto& c : cases) {
    const std::string message = InputErrorOf([&] { LoadMesh(c.path); });
    EXPECT_THAT(message, HasSubstr(c.path));
    EXPECT_THAT(message, HasSubstr(c.text));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  const std::string cube = folder.Write("cube.obj", kCubeObj);
  EXPECT_THAT(InputErrorOf([&] { LoadMesh(cube, "yard"); }), HasSubstr("unknown unit 'yard'"));
}

std::string PlyText(const std::string& faces, int count) {
  return fmt::format(
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face {}\nproperty list uchar int "
      "vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{}",
      count, faces);
}

// A PLY with binary vertices and faces.
std::string BinaryPly() {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    ply.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) put(x);
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (const auto& face : faces) {
    put(uint8_t{3});
    for (const int32_t index : face) put(index);
  }
  return ply;
}

// Ends the text STL, with this normal of its facet.
std::string WithNormal(std::string stl, const std::string& normal) {
  return stl.replace(stl.find("0 0 1"), 5, normal) + "endsolid x\n";
}

// Files that crashed assimp, made it assert or run without end, or that were loaded in part.
TEST(LoadMesh, RefusesDamagedFilesInOneLine) {
  const TemporaryFolder folder;
  const std::string stl =
      "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
      "vertex 0 1 0\nendloop\nendfacet\n";
  struct {
    std::string path;
    const char* text;
  } cases[] = {
      {folder.Write("index.ply", PlyText("3 0 1 2\n3 1 2 5\n", 2)), "cannot read mesh"},
      {folder.Write("huge_index.ply", PlyText("3 0 1 999999999\n", 1)), "cannot read mesh"},
      {folder.Write("negative.ply", PlyText("3 0 1 -1\n", 1)), "cannot read mesh"},
      {folder.Write("quad.ply", PlyText("4 0 1 2 99999\n", 1)), "cannot read mesh"},
      {folder.Write("no_corner.ply", PlyText("0\n3 0 1 2\n", 2)), "cannot read mesh"},
      {folder.Write("cut.ply", PlyText("3 0 1 2\n3 0 1 3\n", 20)), "cannot read mesh"},
      {folder.Write("vertices.ply",
                    "ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n"),
       "have no room for"},
      {folder.Write("cut.stl", stl), "does not end with endsolid"},
      {folder.Write("normal.stl", WithNormal(stl, "0 -1.5e23 0")),
       "a normal with the component -1.5e+23"},
      {folder.Write("cut_face.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 3"), "is incomplete"},
      {folder.Write("cut_index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1/1/1 2/2/2 3/"),
       "is incomplete"},
      {folder.Write("cut_vertex.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 0 1"),
       "is incomplete"},
      {folder.Write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), "cannot read mesh"},
  };
  for (const auto& c : cases) {
    const std::string message = InputErrorOf([&] { LoadMesh(c.path); });
    EXPECT_THAT(message, HasSubstr(c.path));
    EXPECT_THAT(message, HasSubstr(c.text));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_EQ(LoadMesh(folder.Write("no_line_end.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3"))
                .triangles.size(),
            1u);
  for (const char* normal : {"0 0 1", "0 0 1e12", "nan nan nan"}) {
    const TriangleMesh mesh = LoadMesh(folder.Write("whole.stl", WithNormal(stl, normal)));
    EXPECT_EQ(mesh.triangles.size(), 1u) << normal;
  }
}

// assimp crashed on it without its validation.
// assimp 5.2 reads beyond an empty list of materials.
TEST(LoadMesh, LoadsAnObjWhoseMaterialFileNamesNoMaterial) {
  const TemporaryFolder folder;
  const std::string obj = folder.Write(
      "a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\n");
  folder.Write("a.mtl", "# nothing\n");
  EXPECT_EQ(LoadMesh(obj).triangles.size(), 1u);
}

// assimp never ends on a word among the indices of a DAE file.
TEST(LoadMesh, EndsOnADaeWithAWordAmongItsIndices) {
  const TemporaryFolder folder;
  for (const char* const word : {"x", "1.5.2"}) {
    const std::string dae = fmt::format(
        R"(<?xml version="1.0"?><COLLADA version="1.4.1"><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y"
type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 {} 2</p></triangles></mesh></geometry>
</library_geometries></COLLADA>)",
        word);
    const std::string file = folder.Write("a.dae", dae);
    EXPECT_THAT(InputErrorOf([&] { LoadMesh(file); }), HasSubstr(file)) << word;
  }
}

TEST(LoadMesh, RefusesABinaryPlyThatIsCutAnywhere) {
  const TemporaryFolder folder;
  const std::string ply = BinaryPly();
  EXPECT_EQ(LoadMesh(folder.Write("whole.ply", ply)).triangles.size(), 4u);
  for (size_t size = 0; size < ply.size(); size += 7) {
    const std::string path = folder.Write("cut.ply", ply.substr(0, size));
    EXPECT_THAT(InputErrorOf([&] { LoadMesh(path); }), HasSubstr(path)) << size;
  }
  const std::string path = folder.Write("long.ply", ply + "ab");
  EXPECT_THAT(InputErrorOf([&] { LoadMesh(path); }),
              AllOf(HasSubstr(path), HasSubstr("2 bytes after its last element")));
}

TEST(LoadMesh, AnImportIsCachedUntilAUsedFileChanges) {
  const TemporaryFolder folder;
  const std::string obj =
      folder.Write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
  folder.Write("a.mtl", "newmtl red\nKd 1 0 0\n");
  EXPECT_EQ(LoadMesh(obj).base_color, (Rgb8{255, 0, 0}));
  EXPECT_EQ(LoadMesh(obj).base_color, (Rgb8{255, 0, 0}));
  folder.Write("a.mtl", "newmtl red\nKd 0 1 0\n");
  EXPECT_EQ(LoadMesh(obj).base_color, (Rgb8{0, 255, 0}));
  std::filesystem::remove(folder.path() / "a.mtl");
  EXPECT_EQ(LoadMesh(obj).base_color, TriangleMesh().base_color);
}

}  // namespace
}  // namespace pickbed::tests
