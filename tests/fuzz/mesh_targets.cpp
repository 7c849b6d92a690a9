#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "scenes/image/image_io.h"
#include "scenes/mesh_io/material_check.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/mesh_import.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/mesh_io/mesh_text_check.h"
#include "scenes/mesh_io/scene_export.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_hull.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/png_sums.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* kObj =
    "mtllib a.mtl\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n"
    "usemtl red\nf 1/1/1 3/2/1 2/3/1\nf 1/1 2/2 4/3\nf 1 4 3\nf 2 3 4\n";
constexpr const char* kMtl = "newmtl red\nKd 1 0 0\nmap_Kd a.png\n";
constexpr const char* kPlyText =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty "
    "float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n0.1 0 0 1 2 "
    "3\n0 0.1 0 1 2 3\n0 0 0.1 1 2 3\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
constexpr const char* kStlText =
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 "
    "0\nendloop\nendfacet\nfacet normal 0 1 0\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 "
    "0 0.1\nendloop\nendfacet\nendsolid x\n";
constexpr const char* kDae =
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
    "version=\"1.4.1\"><asset><unit meter=\"1\"/><up_axis>Z_UP</up_axis></asset>"
    "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"pa\" "
    "count=\"12\">0 0 0 0.1 0 0 0 0.1 0 0 0 0.1</float_array><technique_common><accessor "
    "source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
    "type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles "
    "count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 0 3 2 1 2 "
    "3</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
    "id=\"s\"><node><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
    "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";

constexpr float kCorners[4][3] = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}};
constexpr int32_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string BinaryPly() {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& corner : kCorners) {
    for (const float x : corner) PutNumber(x, ply);
  }
  for (const auto& face : kFaces) {
    PutNumber(uint8_t{3}, ply);
    for (const int32_t index : face) PutNumber(index, ply);
  }
  return ply;
}

std::string BinaryStl() {
  std::string stl(80, ' ');
  PutNumber(uint32_t{4}, stl);
  for (const auto& face : kFaces) {
    for (int i = 0; i < 3; ++i) PutNumber(0.f, stl);
    for (const int32_t index : face) {
      for (const float x : kCorners[index]) PutNumber(x, stl);
    }
    PutNumber(uint16_t{0}, stl);
  }
  return stl;
}

// Loads a mesh. The importer runs in a child process. libFuzzer does not see the coverage of this
// process, and its crashes are refusals, so that our own code around the importer runs here, too.
// An importer that has not crashed in the child does not crash here.
void ReadMesh(const fs::path& file) {
  CheckMeshFile(file);
  CheckMeshText(file);
  LoadMesh(file);
  ImportMesh(file, 1);
}

FuzzTarget MeshTarget(const std::string& extension, const Contents& seeds) {
  return OneFile("mesh_" + extension, "a." + extension, ReadMesh, [seeds] { return seeds; });
}

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  for (const auto& c : kCorners) mesh.vertices.emplace_back(c[0], c[1], c[2]);
  for (const auto& f : kFaces) mesh.triangles.emplace_back(f[0], f[1], f[2]);
  return mesh;
}

std::string Glb() {
  const TriangleMesh mesh = Tetrahedron();
  GlbPart glb{"tetrahedron", &mesh};
  glb.rgba = {0.5f, 0.25f, 0.75f, 1};
  return GlbBytes(std::vector{glb}, {});
}

// The two chunks of a GLB file: the text of its glTF and the buffer.
std::pair<std::string, std::string> ChunksOf(const std::string& glb) {
  constexpr size_t kHead = 12, kChunkHead = 8;
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + kHead, sizeof length);
  return {glb.substr(kHead + kChunkHead, length), glb.substr(kHead + 2 * kChunkHead + length)};
}

constexpr const char* kBuffer = "a.bin";

// A glTF file whose buffer is a file beside it.
std::string GltfText() {
  std::string text = ChunksOf(Glb()).first;
  const std::string buffers = "\"buffers\":[{";
  return text.insert(text.find(buffers) + buffers.size(), fmt::format("\"uri\":\"{}\",", kBuffer));
}

FuzzTarget GltfTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / kBuffer, ChunksOf(Glb()).second);
    WriteFileAtomically(folder / "a.gltf", bytes);
    ReadMesh(folder / "a.gltf");
  };
  return {"mesh_gltf", run, [] { return Contents{GltfText()}; }};
}

FuzzTarget GltfBufferTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / kBuffer, bytes);
    WriteFileAtomically(folder / "a.gltf", GltfText());
    ReadMesh(folder / "a.gltf");
  };
  return {"mesh_gltf_buffer", run, [] { return Contents{ChunksOf(Glb()).second}; }};
}

FuzzTarget MaterialTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "a.obj", kObj);
    WriteFileAtomically(folder / "a.mtl", bytes);
    CheckMaterials(folder / "a.obj", {folder / "a.mtl"});
    ReadMesh(folder / "a.obj");
  };
  return {"material", run, [] { return Contents{kMtl}; }};
}

FuzzTarget TextureTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "a.obj", kObj);
    WriteFileAtomically(folder / "a.mtl", kMtl);
    WriteFileAtomically(folder / "a.png", WithRightCheckSums(bytes));
    ReadMesh(folder / "a.obj");
  };
  const auto seeds = [] {
    Image<Rgb8> image(9, 7);
    for (size_t i = 0; i < image.size(); ++i) {
      image.data()[i] = {static_cast<uint8_t>(31 * i), 7, static_cast<uint8_t>(i)};
    }
    return Contents{EncodePng(image, 3), EncodeJpeg(image, 90)};
  };
  return {"mesh_texture", run, seeds, true, true, 15};
}

FuzzTarget ObjectTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    const fs::path object = folder / "catalog" / "x";
    MakeFolder(object);
    SaveObj(object / "mesh.obj", Tetrahedron());
    WriteFileAtomically(object / kObjectFile, bytes);
    ObjectCatalog({folder / "catalog"}).Load("x");
  };
  constexpr const char* kObject =
      "mesh: mesh.obj\nunit: m\ndensity_kgpm3: 2700\nfriction: 0.5\nsymmetries:\n  discrete:\n    "
      "- "
      "{axis: [0, 0, 1], angle_deg: 180}\n  continuous: []\n";
  constexpr const char* kHeavy =
      "mesh: mesh.obj\nunit: m\nmass_kg: 0.2\ninertia_diagonal_kgm2: [0.0002, 0.0002, "
      "0.0002]\ncom_m: [0.02, 0.02, 0.02]\nfriction: 0.4\n";
  return {"object", run, [] { return Contents{kObject, kHeavy}; }};
}

FuzzTarget ConvexTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    const fs::path object = folder / "catalog" / "x";
    MakeFolder(object);
    SaveObj(object / "mesh.obj", Tetrahedron());
    WriteFileAtomically(object / "convex.obj", bytes);
    WriteFileAtomically(object / kObjectFile,
                        "mesh: mesh.obj\nmass_kg: 0.2\nfriction: 0.5\nconvex: convex.obj\n");
    const auto model = ObjectCatalog({folder / "catalog"}).Load("x");
    for (const ConvexPiece& piece : model->convex_pieces_O) {
      RequireLaw(!sim::MakeConvexHull(piece.vertices_O).vertices.empty(),
                 "a convex piece has a volume");
    }
  };
  constexpr const char* kPieces =
      "# made by hand\no piece_0\nv 0 0 0\nv 0.05 0 0\nv 0 0.1 0\nv 0 0 0.1\no piece_1\nv 0.05 0 "
      "0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n";
  return {"convex_pieces", run, [] { return Contents{kPieces}; }};
}

}  // namespace

std::vector<FuzzTarget> MeshTargets() {
  return {
      MeshTarget("obj", {kObj}),
      MeshTarget("ply", {kPlyText, BinaryPly()}),
      MeshTarget("stl", {kStlText, BinaryStl()}),
      MeshTarget("dae", {kDae}),
      MeshTarget("glb", {Glb()}),
      GltfTarget(),
      GltfBufferTarget(),
      MaterialTarget(),
      TextureTarget(),
      ObjectTarget(),
      ConvexTarget(),
  };
}

}  // namespace pickbed::tests
