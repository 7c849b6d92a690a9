#include "scenes/mesh_io/scene_export.h"

#include <assimp/GltfMaterial.h>
#include <assimp/anim.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Exporter.hpp>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <set>
#include <stdexcept>

#include "scenes/image/srgb.h"

namespace pickbed::scenes {
namespace {

constexpr float kRoughness = 0.7f;  // of all surfaces; slight highlights make the shape visible

aiVector3D ToAssimp(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

aiMatrix4x4 ToAssimp(const Pose& X) {
  const Eigen::Matrix4f m = X.matrix().cast<float>();
  return {m(0, 0), m(0, 1), m(0, 2), m(0, 3), m(1, 0), m(1, 1), m(1, 2), m(1, 3),
          m(2, 0), m(2, 1), m(2, 2), m(2, 3), 0,       0,       0,       1};
}

aiColor4D LinearOf(const Eigen::Vector3f& rgb, float alpha) {
  return {LinearOfSrgb(rgb.x()), LinearOfSrgb(rgb.y()), LinearOfSrgb(rgb.z()), alpha};
}

std::unique_ptr<aiMaterial> MakeMaterial(const Eigen::Vector4f& rgba, const aiString& name) {
  auto material = std::make_unique<aiMaterial>();
  material->AddProperty(&name, AI_MATKEY_NAME);
  const aiColor4D color = LinearOf(rgba.head<3>(), rgba.w());
  const aiString blend("BLEND");
  const float metallic = 0;
  const int two_sided = 1;  // scanned meshes may be open
  material->AddProperty(&color, 1, AI_MATKEY_BASE_COLOR);
  material->AddProperty(&metallic, 1, AI_MATKEY_METALLIC_FACTOR);
  material->AddProperty(&kRoughness, 1, AI_MATKEY_ROUGHNESS_FACTOR);
  material->AddProperty(&two_sided, 1, AI_MATKEY_TWOSIDED);
  if (rgba.w() < 1) material->AddProperty(&blend, AI_MATKEY_GLTF_ALPHAMODE);
  return material;
}

std::unique_ptr<aiMesh> MakeMesh(const TriangleMesh& source) {
  auto mesh = std::make_unique<aiMesh>();
  mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh->mNumVertices = static_cast<unsigned>(source.vertices.size());
  mesh->mVertices = new aiVector3D[source.vertices.size()];
  for (size_t i = 0; i < source.vertices.size(); ++i) {
    mesh->mVertices[i] = ToAssimp(source.vertices[i].cast<float>());
  }
  if (!source.normals.empty()) {
    mesh->mNormals = new aiVector3D[source.normals.size()];
    for (size_t i = 0; i < source.normals.size(); ++i) {
      mesh->mNormals[i] = ToAssimp(source.normals[i].cast<float>());
    }
  }
  mesh->mNumFaces = static_cast<unsigned>(source.triangles.size());
  mesh->mFaces = new aiFace[source.triangles.size()];
  for (size_t i = 0; i < source.triangles.size(); ++i) {
    const Eigen::Vector3i& t = source.triangles[i];
    mesh->mFaces[i].mNumIndices = 3;
    mesh->mFaces[i].mIndices = new unsigned[3]{unsigned(t[0]), unsigned(t[1]), unsigned(t[2])};
  }
  return mesh;
}

std::unique_ptr<aiMesh> MakePoints(const GlbCloud& cloud) {
  const size_t count = cloud.points_W.size();
  auto mesh = std::make_unique<aiMesh>();
  mesh->mPrimitiveTypes = aiPrimitiveType_POINT;
  mesh->mNumVertices = mesh->mNumFaces = static_cast<unsigned>(count);
  mesh->mVertices = new aiVector3D[count];
  mesh->mColors[0] = new aiColor4D[count];
  mesh->mFaces = new aiFace[count];
  for (size_t i = 0; i < count; ++i) {
    mesh->mVertices[i] = ToAssimp(cloud.points_W[i]);
    mesh->mColors[0][i] = LinearOf(cloud.rgb[i], 1);
    mesh->mFaces[i].mNumIndices = 1;
    mesh->mFaces[i].mIndices = new unsigned[1]{static_cast<unsigned>(i)};
  }
  return mesh;
}

void RequireFilled(std::span<const GlbPart> glb_parts, std::span<const GlbCloud> clouds) {
  for (const GlbPart& glb_part : glb_parts) {
    if (glb_part.mesh == nullptr || glb_part.mesh->triangles.empty()) {
      throw std::logic_error("mesh '" + glb_part.name + "' of a GLB has no triangles");
    }
  }
  for (const GlbCloud& cloud : clouds) {
    if (cloud.points_W.empty() || cloud.rgb.size() != cloud.points_W.size()) {
      throw std::logic_error("cloud '" + cloud.name + "' of a GLB has no points or no colors");
    }
  }
  std::set<std::string> names;
  for (const GlbPart& glb_part : glb_parts) {
    if (!names.insert(glb_part.name).second && !glb_part.track_W.empty()) {
      throw std::logic_error("two parts of an animated GLB have the name '" + glb_part.name + "'");
    }
  }
  if (glb_parts.empty() && clouds.empty())
    throw std::logic_error("a GLB needs at least one mesh or cloud");
}

// Returns a raw array of the items, which the aiScene or aiNode then owns.
template <typename T>
T** Owned(std::vector<std::unique_ptr<T>>& items) {
  T** array = new T*[items.size()];
  for (size_t i = 0; i < items.size(); ++i) array[i] = items[i].release();
  return array;
}

struct Contents {
  std::vector<std::unique_ptr<aiNode>> nodes;
  std::vector<std::unique_ptr<aiMesh>> meshes;
  std::vector<std::unique_ptr<aiMaterial>> materials;  // one for each mesh

  unsigned Add(std::unique_ptr<aiMesh> mesh, const Eigen::Vector4f& rgba, const std::string& name) {
    mesh->mName = name;
    mesh->mMaterialIndex = static_cast<unsigned>(materials.size());
    materials.push_back(MakeMaterial(rgba, mesh->mName));
    meshes.push_back(std::move(mesh));
    return static_cast<unsigned>(meshes.size()) - 1;
  }
  void AddNode(const std::string& name, const Pose& X_W, unsigned mesh) {
    auto node = std::make_unique<aiNode>(name);
    node->mTransformation = ToAssimp(X_W);
    node->mNumMeshes = 1;
    node->mMeshes = new unsigned[1]{mesh};
    nodes.push_back(std::move(node));
  }
};

Contents ContentsOf(std::span<const GlbPart> glb_parts, std::span<const GlbCloud> clouds) {
  Contents contents;
  std::vector<unsigned> mesh_of;  // mesh index of each part so far
  for (const GlbPart& glb_part : glb_parts) {
    const auto same = std::find_if(
        glb_parts.begin(), glb_parts.begin() + mesh_of.size(),
        [&](auto& other) { return other.mesh == glb_part.mesh && other.rgba == glb_part.rgba; });
    const size_t first = same - glb_parts.begin();
    mesh_of.push_back(first < mesh_of.size()
                          ? mesh_of[first]
                          : contents.Add(MakeMesh(*glb_part.mesh), glb_part.rgba, glb_part.name));
    contents.AddNode(glb_part.name, glb_part.X_W, mesh_of.back());
  }
  for (const GlbCloud& cloud : clouds) {
    const unsigned mesh = contents.Add(MakePoints(cloud), Eigen::Vector4f::Ones(), cloud.name);
    contents.AddNode(cloud.name, Pose::Identity(), mesh);
  }
  return contents;
}

std::unique_ptr<aiScene> MakeAssimpScene(Contents contents) {
  auto scene = std::make_unique<aiScene>();
  scene->mFlags = AI_SCENE_FLAGS_NON_VERBOSE_FORMAT;  // keeps the vertices that faces share
  scene->mRootNode = new aiNode("world");
  aiNode& root = *scene->mRootNode;
  // Rotates z up to y up: x stays, z becomes y, y becomes -z.
  root.mTransformation = aiMatrix4x4(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1);
  for (const auto& node : contents.nodes) node->mParent = &root;
  root.mNumChildren = static_cast<unsigned>(contents.nodes.size());
  root.mChildren = Owned(contents.nodes);
  scene->mNumMeshes = static_cast<unsigned>(contents.meshes.size());
  scene->mMeshes = Owned(contents.meshes);
  scene->mNumMaterials = static_cast<unsigned>(contents.materials.size());
  scene->mMaterials = Owned(contents.materials);
  return scene;
}

// Positions and rotations of one part over time. The times are in frames.
std::unique_ptr<aiNodeAnim> MakeChannel(const GlbPart& glb_part) {
  auto channel = std::make_unique<aiNodeAnim>();
  const size_t count = glb_part.track_W.size();
  channel->mNodeName = glb_part.name;
  channel->mNumPositionKeys = channel->mNumRotationKeys = static_cast<unsigned>(count);
  channel->mPositionKeys = new aiVectorKey[count];
  channel->mRotationKeys = new aiQuatKey[count];
  Eigen::Quaternionf last = Eigen::Quaternionf::Identity();
  for (size_t i = 0; i < count; ++i) {
    const Pose& X_W = glb_part.track_W[i];
    Eigen::Quaternionf q(Eigen::Quaterniond(X_W.linear()).cast<float>());
    // A quaternion and its negative are the same rotation. Viewers take the short way between two
    // frames only if their signs agree.
    if (q.dot(last) < 0) q.coeffs() *= -1;
    last = q;
    const auto time = static_cast<double>(i);
    channel->mPositionKeys[i] = aiVectorKey(time, ToAssimp(X_W.translation().cast<float>()));
    channel->mRotationKeys[i] = aiQuatKey(time, aiQuaternion(q.w(), q.x(), q.y(), q.z()));
  }
  channel->mNumScalingKeys = 1;
  channel->mScalingKeys = new aiVectorKey[1]{aiVectorKey(0, aiVector3D(1, 1, 1))};
  return channel;
}

// Adds the animation of the parts with a track to a scene, if there are any.
void AddAnimation(std::span<const GlbPart> glb_parts, double frame_s, aiScene& scene) {
  std::vector<std::unique_ptr<aiNodeAnim>> channels;
  size_t frames = 0;
  for (const GlbPart& glb_part : glb_parts) {
    if (glb_part.track_W.empty()) continue;
    channels.push_back(MakeChannel(glb_part));
    frames = std::max(frames, glb_part.track_W.size());
  }
  if (channels.empty()) return;
  auto* animation = new aiAnimation();
  animation->mName = "motion";
  animation->mDuration = static_cast<double>(frames - 1);
  animation->mTicksPerSecond = 1 / frame_s;
  animation->mNumChannels = static_cast<unsigned>(channels.size());
  animation->mChannels = Owned(channels);
  scene.mNumAnimations = 1;
  scene.mAnimations = new aiAnimation* [1] { animation };
}

}  // namespace

std::string GlbBytes(std::span<const GlbPart> glb_parts, std::span<const GlbCloud> clouds,
                     double frame_s) {
  RequireFilled(glb_parts, clouds);
  const auto scene = MakeAssimpScene(ContentsOf(glb_parts, clouds));
  AddAnimation(glb_parts, frame_s, *scene);
  Assimp::Exporter exporter;
  const aiExportDataBlob* blob = exporter.ExportToBlob(scene.get(), "glb2");
  if (blob == nullptr) {
    throw std::runtime_error(std::string("cannot make a GLB: ") + exporter.GetErrorString());
  }
  return {static_cast<const char*>(blob->data), blob->size};
}

static_assert(std::endian::native == std::endian::little,
              "floats are written in the byte order of the machine");

std::string PlyCloudBytes(std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Vector3f> rgb) {
  if (points.size() != rgb.size()) throw std::logic_error("a PLY needs a color for each point");
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    char xyz[3 * sizeof(float)];
    std::memcpy(xyz, points[i].data(), sizeof(xyz));
    bytes.append(xyz, sizeof(xyz));
    for (const float channel : rgb[i]) {
      bytes += static_cast<char>(std::lround(255 * std::clamp(channel, 0.f, 1.f)));
    }
  }
  return bytes;
}

}  // namespace pickbed::scenes
