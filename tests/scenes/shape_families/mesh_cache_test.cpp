#include "scenes/shape_families/mesh_cache.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenes/base/files.h"
#include "scenes/shape_families/solid_builder.h"
#include "scenes/shape_families/solid_mesh.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

bool AreEqual(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.normals == b.normals && a.triangles == b.triangles;
}

TEST(MeshCache, GivesTheMeshOfTheSolidAndReplacesDamagedFiles) {
  // No other test has a box of this size.
  const SolidShape solid = CompiledSolid(Box({41.25f, 33.5f, 17.75f}), 15);
  const TriangleMesh mesh = MeshOfSolid(solid);
  ASSERT_FALSE(mesh.normals.empty());
  CachedMeshOfSolid(solid);
  std::filesystem::path file;
  for (const auto& entry : std::filesystem::directory_iterator(CacheDir() / "shapes")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(fmt::format("{:016x}", solid.hash()))) file = entry.path();
  }
  ASSERT_FALSE(file.empty());
  EXPECT_TRUE(AreEqual(CachedMeshOfSolid(solid), mesh)) << "read";
  std::string bytes = ReadFileBytes(file);
  const std::string whole = bytes;
  bytes[bytes.size() / 2] ^= 1;
  for (const std::string& damaged : {bytes, whole.substr(0, whole.size() - 5), std::string()}) {
    WriteFileAtomically(file, damaged);
    EXPECT_TRUE(AreEqual(CachedMeshOfSolid(solid), mesh)) << damaged.size();
    EXPECT_EQ(ReadFileBytes(file), whole) << damaged.size();
  }
}

}  // namespace
}  // namespace pickbed::tests
