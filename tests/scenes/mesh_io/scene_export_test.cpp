#include "scenes/mesh_io/scene_export.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>

#include <assimp/Importer.hpp>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "scenes/mesh_io/scene_export.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::ElementsAre;
using testing::FloatNear;

uint32_t UintAt(const std::string& bytes, size_t place) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + place, sizeof(word));
  return word;
}

// Checks the header (glTF 2.0, section 4.4) and returns the file's JSON chunk.
nlohmann::json JsonChunk(const std::string& glb) {
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(UintAt(glb, 4), 2u);
  EXPECT_EQ(UintAt(glb, 8), glb.size());
  const uint32_t length = UintAt(glb, 12);
  EXPECT_EQ(glb.substr(16, 4), "JSON");
  EXPECT_EQ(length % 4, 0u);
  EXPECT_EQ(glb.substr(24 + length, 4), std::string("BIN\0", 4));
  EXPECT_EQ(28 + length + UintAt(glb, 20 + length), glb.size());
  return nlohmann::json::parse(glb.substr(20, length));
}

// A file as read by assimp.
struct ReadBack {
  explicit ReadBack(const std::string& bytes, const char* format = "glb") {
    scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, format);
    if (scene == nullptr) throw std::runtime_error(importer.GetErrorString());
  }
  const aiNode& node(const char* name) const {
    const aiNode* found = scene->mRootNode->FindNode(name);
    if (found == nullptr) throw std::runtime_error(std::string("no node ") + name);
    return *found;
  }
  const aiMesh& mesh(const char* name) const { return *scene->mMeshes[node(name).mMeshes[0]]; }
  aiColor4D color(const char* name) const {
    aiColor4D color;
    scene->mMaterials[mesh(name).mMaterialIndex]->Get(AI_MATKEY_BASE_COLOR, color);
    return color;
  }
  // Returns the position of a vertex in the glTF world frame (y up), in metres.
  Vector3f VertexPosition(const char* name, unsigned vertex) const {
    aiMatrix4x4 X;
    for (const aiNode* n = &node(name); n != nullptr; n = n->mParent) X = n->mTransformation * X;
    const aiVector3D p = X * mesh(name).mVertices[vertex];
    return {p.x, p.y, p.z};
  }

  Assimp::Importer importer;
  const aiScene* scene;
};

Pose SomePose() {
  return Translation({0.1, -0.2, 0.3}) * Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
}

GlbCloud ThreePoints() {
  return {"cloud",
          {{0, 0, 0.5f}, {0.25f, 0, 0}, {0, -0.125f, 0}},
          {{1, 0, 0}, {0, 0.5f, 0}, {1, 1, 1}}};
}

TEST(GlbBytes, MeshesKeepTheirPoseWithWorldZUp) {
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3}), ball = BallShape(0.05, 1);
  const std::vector<GlbPart> glb_parts = {
      {"box", &box, SomePose(), {1, 0, 0, 1}},
      {"ball", &ball, Translation({0, 0, 1}), {0, 0, 1, 0.25f}}};
  const ReadBack read(GlbBytes(glb_parts, {}));
  for (const GlbPart& glb_part : glb_parts) {
    const aiMesh& mesh = read.mesh(glb_part.name.c_str());
    ASSERT_EQ(mesh.mNumFaces, glb_part.mesh->triangles.size());
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      ASSERT_EQ(mesh.mFaces[f].mNumIndices, 3u);
      for (int k = 0; k < 3; ++k) {
        const Vector3d p_W = glb_part.X_W * glb_part.mesh->vertices[glb_part.mesh->triangles[f][k]];
        const Vector3f exported =
            read.VertexPosition(glb_part.name.c_str(), mesh.mFaces[f].mIndices[k]);
        EXPECT_LT((exported - Vector3f(p_W.x(), p_W.z(), -p_W.y())).norm(), 1e-6f);
      }
    }
  }
}

TEST(GlbBytes, SmoothNormalsAreWrittenAndFlatNormalsAreNot) {
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3}), ball = BallShape(0.05, 1);
  const std::vector<GlbPart> glb_parts = {{"box", &box}, {"ball", &ball}};
  const ReadBack read(GlbBytes(glb_parts, {}));
  EXPECT_FALSE(read.mesh("box").HasNormals());
  const aiMesh& mesh = read.mesh("ball");
  ASSERT_TRUE(mesh.HasNormals());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    EXPECT_LT((mesh.mVertices[i] / 0.05f - mesh.mNormals[i]).Length(), 1e-5f);
  }
}

TEST(GlbBytes, ColorsAreLinearInTheFile) {
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3});
  const std::vector<GlbPart> glb_parts = {{"opaque", &box, Pose::Identity(), {0, 0.5f, 1, 1}},
                                          {"glass", &box, Pose::Identity(), {1, 0.02f, 0, 0.25f}}};
  const std::string glb = GlbBytes(glb_parts, {});
  const ReadBack read(glb);
  // sRGB 0.5 is 0.2140 linear. Below 0.04045 the curve is a line of slope 1/12.92.
  EXPECT_LT((aiVector3D(0, 0.21404f, 1) -
             aiVector3D(read.color("opaque").r, read.color("opaque").g, read.color("opaque").b))
                .Length(),
            1e-4f);
  EXPECT_NEAR(read.color("glass").g, 0.02 / 12.92, 1e-6);
  EXPECT_EQ(read.color("glass").a, 0.25f);
  const nlohmann::json json = JsonChunk(glb);
  for (const auto& material : json["materials"]) {
    const auto& pbr = material["pbrMetallicRoughness"];
    // A metal looks black without an environment map.
    EXPECT_EQ(pbr.value("metallicFactor", 1.0), 0.0);
    const bool glass = pbr["baseColorFactor"][3] < 1;
    EXPECT_EQ(material.value("alphaMode", "OPAQUE"), glass ? "BLEND" : "OPAQUE");
  }
}

TEST(GlbBytes, EqualMeshesOfEqualColorShareTheirGeometry) {
  const TriangleMesh ball = BallShape(0.05, 4);
  const GlbPart red{"a", &ball, Pose::Identity(), {1, 0, 0, 1}};
  std::vector<GlbPart> glb_parts = {red};
  const size_t one = GlbBytes(glb_parts, {}).size();
  for (const char* name : {"b", "c", "d"}) glb_parts.push_back({name, &ball, SomePose(), red.rgba});
  const std::string four = GlbBytes(glb_parts, {});
  EXPECT_LT(four.size(), one + 2000);
  EXPECT_EQ(ReadBack(four).scene->mNumMeshes, 1u);
  glb_parts[3].rgba.x() = 0.5f;
  EXPECT_EQ(ReadBack(GlbBytes(glb_parts, {})).scene->mNumMeshes, 2u);
}

TEST(GlbBytes, CloudsAreColoredPoints) {
  const GlbCloud cloud = ThreePoints();
  const std::string glb = GlbBytes({}, {&cloud, 1});
  const ReadBack read(glb);
  const aiMesh& mesh = read.mesh("cloud");
  EXPECT_EQ(mesh.mPrimitiveTypes, aiPrimitiveType_POINT);
  ASSERT_EQ(mesh.mNumVertices, 3u);
  ASSERT_NE(mesh.mColors[0], nullptr);
  for (unsigned i = 0; i < 3; ++i) {
    const Vector3f& p_W = cloud.points_W[i];
    EXPECT_EQ(read.VertexPosition("cloud", i), Vector3f(p_W.x(), p_W.z(), -p_W.y())) << i;
  }
  EXPECT_NEAR(mesh.mColors[0][1].g, 0.21404, 1e-4);
  EXPECT_EQ(mesh.mColors[0][2], aiColor4D(1, 1, 1, 1));

  const nlohmann::json json = JsonChunk(glb);
  const auto& primitive = json["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["mode"], 0);  // POINTS
  const auto& positions = json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
  EXPECT_EQ(positions["count"], 3);
  EXPECT_THAT(positions["min"].get<std::vector<float>>(), ElementsAre(0, -0.125f, 0));
  EXPECT_THAT(positions["max"].get<std::vector<float>>(), ElementsAre(0.25f, 0, 0.5f));
}

// Viewers refuse such faults, but assimp accepts them.
TEST(GlbBytes, AccessorsStayInsideTheirBuffers) {
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3}), ball = BallShape(0.05, 2);
  const std::vector<GlbPart> glb_parts = {{"box", &box},
                                          {"ball", &ball, SomePose(), {1, 0, 0, 0.5f}}};
  const GlbCloud cloud = ThreePoints();
  const std::string glb = GlbBytes(glb_parts, {&cloud, 1});
  const nlohmann::json json = JsonChunk(glb);
  EXPECT_EQ(json["asset"]["version"], "2.0");
  EXPECT_LE(json["buffers"][0]["byteLength"], UintAt(glb, 20 + UintAt(glb, 12)));
  const std::map<int, size_t> bytes_of = {{5121, 1}, {5123, 2}, {5125, 4}, {5126, 4}};
  const std::map<std::string, size_t> numbers_of = {{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}};
  for (const auto& accessor : json["accessors"]) {
    const size_t bytes = bytes_of.at(accessor["componentType"]);
    const size_t numbers = numbers_of.at(accessor["type"]);
    const auto& view = json["bufferViews"][accessor["bufferView"].get<size_t>()];
    const size_t offset = accessor.value("byteOffset", 0) + view.value("byteOffset", 0);
    EXPECT_EQ(offset % bytes, 0u) << accessor;
    EXPECT_LE(accessor.value("byteOffset", 0) + accessor["count"].get<size_t>() * bytes * numbers,
              view["byteLength"])
        << accessor;
    EXPECT_LE(view.value("byteOffset", 0) + view["byteLength"].get<size_t>(),
              json["buffers"][0]["byteLength"]);
  }
}

TEST(GlbBytes, SameInputGivesSameBytes) {
  const TriangleMesh ball = BallShape(0.05, 2);
  const std::vector<GlbPart> glb_parts = {{"ball", &ball, SomePose(), {1, 0, 0, 0.5f}}};
  const GlbCloud cloud = ThreePoints();
  EXPECT_EQ(GlbBytes(glb_parts, {&cloud, 1}), GlbBytes(glb_parts, {&cloud, 1}));
}

TEST(GlbBytes, RefusesEmptyMeshesAndScenes) {
  const TriangleMesh empty;
  const std::vector<GlbPart> glb_parts = {{"nothing", &empty}};
  EXPECT_THROW(GlbBytes(glb_parts, {}), std::logic_error);
  EXPECT_THROW(GlbBytes({}, {}), std::logic_error);
  GlbCloud cloud = ThreePoints();
  cloud.rgb.pop_back();
  EXPECT_THROW(GlbBytes({}, {&cloud, 1}), std::logic_error);
}

TEST(PlyCloudBytes, HoldEachPointAndColor) {
  const GlbCloud cloud = ThreePoints();
  const std::string ply = PlyCloudBytes(cloud.points_W, cloud.rgb);
  EXPECT_TRUE(ply.starts_with("ply\nformat binary_little_endian 1.0\nelement vertex 3\n"));
  const size_t header = ply.find("end_header\n") + 11;
  ASSERT_EQ(ply.size(), header + 3 * 15);
  for (size_t i = 0; i < 3; ++i) {
    Vector3f point;
    std::memcpy(point.data(), ply.data() + header + 15 * i, 12);
    EXPECT_EQ(point, cloud.points_W[i]);
  }
  EXPECT_EQ(ply.substr(header + 15 + 12, 3), std::string("\x00\x80\x00", 3));
}

TEST(PlyCloudBytes, NeedAColorForEachPoint) {
  const GlbCloud cloud = ThreePoints();
  EXPECT_THROW(PlyCloudBytes(cloud.points_W, {}), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
