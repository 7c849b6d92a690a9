#include "scenes/shape_families/mesh_cache.h"

#include <fmt/format.h>

#include "scenes/base/cache_file.h"
#include "scenes/geometry/mesh_bytes.h"
#include "scenes/shape_families/solid_mesh.h"

namespace pickbed::scenes {
namespace {

// Part of the file name. Raise it when MeshOfSolid() gives another mesh.
constexpr int kMeshVersion = 3;

}  // namespace

TriangleMesh CachedMeshOfSolid(const SolidShape& solid) {
  const std::filesystem::path file =
      CacheDir() / "shapes" / fmt::format("{:016x}-v{}.mesh", solid.hash(), kMeshVersion);
  return Cached(
      file, MeshFromBytes, [&] { return MeshOfSolid(solid); }, MeshToBytes);
}

}  // namespace pickbed::scenes
