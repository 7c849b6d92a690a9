#include "scenes/shape_families/mesh_cache.h"

#include <fmt/format.h>

#include <cstring>
#include <optional>
#include <string>

#include "scenes/base/cache_lock.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/shape_families/solid_mesh.h"

namespace pickbed::scenes {
namespace {

// Part of the file name. Raise it when MeshOfSolid() gives another mesh.
constexpr int kMeshVersion = 2;

struct Header {
  uint64_t hash = 0;  // of the rest of the file
  uint64_t vertices = 0, triangles = 0;
};

template <typename Row>
void Append(const std::vector<Row>& rows, std::string& bytes) {
  for (const Row& row : rows) {
    bytes.append(reinterpret_cast<const char*>(row.data()), sizeof(*row.data()) * row.size());
  }
}

template <typename Row>
const char* Take(const char* from, uint64_t count, std::vector<Row>& rows) {
  rows.resize(count);
  for (Row& row : rows) {
    std::memcpy(row.data(), from, sizeof(*row.data()) * row.size());
    from += sizeof(*row.data()) * row.size();
  }
  return from;
}

std::string ToBytes(const TriangleMesh& mesh) {
  std::string rows;
  Append(mesh.vertices, rows);
  Append(mesh.normals, rows);
  Append(mesh.triangles, rows);
  const Header header{HashBytes(rows.data(), rows.size()), mesh.vertices.size(),
                      mesh.triangles.size()};
  return std::string(reinterpret_cast<const char*>(&header), sizeof header) + rows;
}

// Returns nullopt if the file is missing or damaged.
std::optional<TriangleMesh> ReadMesh(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  const std::string bytes = ReadFileBytes(file);
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  const char* rows = bytes.data() + sizeof header;
  const size_t size = bytes.size() - sizeof header;
  const size_t vertex_bytes = 2 * sizeof(Eigen::Vector3d), triangle_bytes = sizeof(Eigen::Vector3i);
  if (header.vertices > size || header.triangles > size ||
      header.vertices * vertex_bytes + header.triangles * triangle_bytes != size ||
      header.hash != HashBytes(rows, size)) {
    return std::nullopt;
  }
  TriangleMesh mesh;
  rows = Take(rows, header.vertices, mesh.vertices);
  rows = Take(rows, header.vertices, mesh.normals);
  Take(rows, header.triangles, mesh.triangles);
  return mesh;
}

}  // namespace

TriangleMesh CachedMeshOfSolid(const SolidShape& solid) {
  const std::filesystem::path file =
      CacheDir() / "shapes" / fmt::format("{:016x}-v{}.mesh", solid.hash(), kMeshVersion);
  if (std::optional<TriangleMesh> cached = ReadMesh(file)) return std::move(*cached);
  MakeFolder(file.parent_path());
  const CacheLock lock(file);
  if (std::optional<TriangleMesh> cached = ReadMesh(file)) return std::move(*cached);
  TriangleMesh mesh = MeshOfSolid(solid);
  WriteFileAtomically(file, ToBytes(mesh));
  return mesh;
}

}  // namespace pickbed::scenes
