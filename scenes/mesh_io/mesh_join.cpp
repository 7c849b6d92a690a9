#include "scenes/mesh_io/mesh_join.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <unordered_map>

namespace pickbed::scenes {
namespace {

// The values that must be equal for two corners to become one vertex.
using VertexKey = std::array<double, 11>;

struct VertexKeyHash {
  size_t operator()(const VertexKey& key) const {
    uint64_t hash = 0;
    for (const double value : key) {
      uint64_t bits;
      std::memcpy(&bits, &value, sizeof(bits));
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32;
    }
    return hash;
  }
};

struct SameBytes {
  bool operator()(const VertexKey& a, const VertexKey& b) const {
    return std::memcmp(&a, &b, sizeof(a)) == 0;  // NaN equals itself
  }
};

VertexKey KeyOf(const TriangleMesh& mesh, int i) {
  VertexKey key{};
  double* next = key.data();
  const auto add = [&next](double value) { *next++ = value + 0.0; };  // -0 becomes 0
  for (int k = 0; k < 3; ++k) add(mesh.vertices[i][k]);
  for (int k = 0; k < 3 && !mesh.normals.empty(); ++k) add(mesh.normals[i][k]);
  for (int k = 0; k < 2 && !mesh.uvs.empty(); ++k) add(mesh.uvs[i][k]);
  if (!mesh.colors.empty()) {
    add(mesh.colors[i].r);
    add(mesh.colors[i].g);
    add(mesh.colors[i].b);
  }
  return key;
}

}  // namespace

void DropDegenerate(TriangleMesh& mesh) {
  const std::vector<Eigen::Vector3d>& v = mesh.vertices;
  std::erase_if(mesh.triangles, [&](const Eigen::Vector3i& t) {
    return v[t[0]] == v[t[1]] || v[t[1]] == v[t[2]] || v[t[2]] == v[t[0]];
  });
}

bool NormalsAreUnit(const TriangleMesh& mesh) {
  return std::all_of(mesh.normals.begin(), mesh.normals.end(),
                     [](const Eigen::Vector3d& n) { return std::abs(n.squaredNorm() - 1) < 1e-6; });
}

void DropFlatNormals(TriangleMesh& mesh) {
  constexpr double kSameDirection = 1 - 1e-6;  // cosine; 0.08 degrees
  if (mesh.normals.empty()) return;
  const bool all_unit = NormalsAreUnit(mesh);
  const std::vector<Eigen::Vector3d> faces = FaceNormals(mesh);
  for (size_t i = 0; i < faces.size() && all_unit; ++i) {
    for (const int corner : mesh.triangles[i]) {
      if (!faces[i].isZero(0) && faces[i].dot(mesh.normals[corner]) < kSameDirection) return;
    }
  }
  mesh.normals.clear();
}

TriangleMesh WithEqualVerticesJoined(const TriangleMesh& mesh) {
  TriangleMesh joined;
  joined.base_color = mesh.base_color;
  joined.texture = mesh.texture;
  joined.triangles = mesh.triangles;
  std::unordered_map<VertexKey, int, VertexKeyHash, SameBytes> index_of;
  index_of.reserve(mesh.vertices.size() / 2);
  for (Eigen::Vector3i& t : joined.triangles) {
    for (int& i : t) {
      const auto [place, is_new] =
          index_of.try_emplace(KeyOf(mesh, i), static_cast<int>(joined.vertices.size()));
      if (is_new) {
        joined.vertices.push_back(mesh.vertices[i] + Eigen::Vector3d::Zero());
        if (!mesh.normals.empty()) joined.normals.push_back(mesh.normals[i]);
        if (!mesh.uvs.empty()) joined.uvs.push_back(mesh.uvs[i]);
        if (!mesh.colors.empty()) joined.colors.push_back(mesh.colors[i]);
      }
      i = place->second;
    }
  }
  return joined;
}

std::array<uint64_t, 2> UncoloredHashes(TriangleMesh mesh) {
  mesh.colors.clear();
  mesh.uvs.clear();
  const uint64_t with_normals = MeshHash(WithEqualVerticesJoined(mesh));
  mesh.normals.clear();
  return {with_normals, MeshHash(WithEqualVerticesJoined(mesh))};
}

}  // namespace pickbed::scenes
