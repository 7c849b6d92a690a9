#include "sim/convex/convex_pieces.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "scenes/base/cache_file.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/part_families/part_families.h"
#include "sim/convex/convex_hull.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

double SumOfVolumes(const std::vector<ConvexPiece>& pieces) {
  double volume_m3 = 0;
  for (const ConvexPiece& piece : pieces) {
    volume_m3 += MakeConvexHull(piece.vertices_O).Volume();
  }
  return volume_m3;
}

// Returns the distance by which a point is outside the nearest hull, in metres; negative inside.
double DistanceOutside_m(const std::vector<ConvexHull>& hulls, const Vector3d& p) {
  double min_m = 1;
  for (const ConvexHull& hull : hulls) {
    double max_m = -1;
    for (size_t i = 0; i < hull.triangles.size(); ++i) {
      const Vector3d& n = hull.normals[hull.triangle_faces[i]];
      max_m = std::max(max_m, n.dot(p - hull.vertices[hull.triangles[i][0]]));
    }
    min_m = std::min(min_m, max_m);
  }
  return min_m;
}

double LargestUncovered_m(const TriangleMesh& mesh, const std::vector<ConvexPiece>& pieces) {
  std::vector<ConvexHull> hulls;
  for (const ConvexPiece& piece : pieces) hulls.push_back(MakeConvexHull(piece.vertices_O));
  Rng rng(3);
  double worst_m = 0;
  for (const Vector3d& p : SampleSurface(mesh, 2000, rng).points) {
    worst_m = std::max(worst_m, DistanceOutside_m(hulls, p));
  }
  return worst_m;
}

FamilyObject Made(const std::string& name) {
  for (const FamilyRow& row : FamilyTable()) {
    if (name == row.name) return row.make();
  }
  throw std::logic_error("no object " + name);
}

TEST(ConvexHull, IgnoresPointsInsideACube) {
  std::vector<Vector3d> points = BoxPiece({{0.1, 0.2, 0.3}, {0.5, 0.5, 0.5}}).vertices_O;
  points.emplace_back(0.1, 0.2, 0.3);
  points.emplace_back(0.2, 0.0, 0.5);
  const ConvexHull hull = MakeConvexHull(points);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_EQ(hull.normals.size(), 6u);
  EXPECT_EQ(hull.edges.size(), 12u);
  EXPECT_NEAR(hull.Volume(), 1, 1e-12);
}

TEST(ConvexHull, FlatPointsHaveNoVolume) {
  const std::vector<Vector3d> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_NEAR(MakeConvexHull(square).Volume(), 0, 1e-12);
  EXPECT_TRUE(MakeConvexHull(std::vector<Vector3d>{{0, 0, 0}}).vertices.empty());
}

TEST(DecomposeConvex, KeepsAConvexObjectWhole) {
  const AxisAlignedBox box{{0.01, 0, 0}, {0.02, 0.03, 0.04}};
  const std::vector<ConvexPiece> pieces = DecomposeConvex(BoxMesh(box));
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].vertices_O.size(), 8u);
  EXPECT_NEAR(SumOfVolumes(pieces), 8 * box.half_size.prod(), 1e-15);
}

// The clip is a U of three boxes with chamfers, so a decomposition into six pieces is exact.
TEST(DecomposeConvex, DecomposesAClipExactly) {
  const FamilyObject clip = Made("u_clip");
  const double volume_m3 = UniformMassProperties(clip.mesh_O, 1).volume_m3;
  const std::vector<ConvexPiece> pieces = DecomposeConvex(clip.mesh_O);
  EXPECT_LE(pieces.size(), 8u);
  EXPECT_NEAR(SumOfVolumes(pieces) / volume_m3, 1, 0.02);
  EXPECT_LT(LargestUncovered_m(clip.mesh_O, pieces), 1e-6);
}

class DecomposedFamilies : public ::testing::TestWithParam<const char*> {};

TEST_P(DecomposedFamilies, ObeyTheLimitsAndCoverTheSurface) {
  const FamilyObject object = Made(GetParam());
  const DecompositionOptions options;
  const std::vector<ConvexPiece> pieces = DecomposeConvex(object.mesh_O, options);
  EXPECT_LE(static_cast<int>(pieces.size()), options.max_pieces);
  for (const ConvexPiece& piece : pieces) {
    EXPECT_LE(static_cast<int>(piece.vertices_O.size()), options.max_vertices);
    EXPECT_GE(piece.vertices_O.size(), 4u);
  }
  EXPECT_LT(LargestUncovered_m(object.mesh_O, pieces), 0.02 * Diameter(object.mesh_O));
}
INSTANTIATE_TEST_SUITE_P(Families, DecomposedFamilies,
                         ::testing::Values("bracket", "gear", "hex_bolt", "elbow", "mug"));

TEST(DecomposeConvex, RepeatsExactly) {
  const TriangleMesh mesh = Made("bracket").mesh_O;
  const auto first = DecomposeConvex(mesh), second = DecomposeConvex(mesh);
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].vertices_O, second[i].vertices_O);
  }
}

TEST(WithConvexPieces, KeepsExistingPieces) {
  const auto object = BracketObject();
  EXPECT_EQ(WithConvexPieces(object).get(), object.get());
}

class CachedPieces : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
    auto bare = std::make_shared<ObjectModel>(*BracketObject());
    bare->convex_pieces_O.clear();
    bare_ = bare;
  }
  std::vector<std::filesystem::path> Files() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
    return files;
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
  std::shared_ptr<const ObjectModel> bare_;
};

TEST_F(CachedPieces, ReadBackExactly) {
  const auto made = WithConvexPieces(bare_);
  ASSERT_EQ(Files().size(), 1u);
  const auto read = WithConvexPieces(bare_);
  ASSERT_EQ(made->convex_pieces_O.size(), read->convex_pieces_O.size());
  for (size_t i = 0; i < made->convex_pieces_O.size(); ++i) {
    EXPECT_EQ(made->convex_pieces_O[i].vertices_O, read->convex_pieces_O[i].vertices_O);
  }
}

TEST_F(CachedPieces, AreReadFromTheCache) {
  WithConvexPieces(bare_);
  WriteCacheFile(Files().at(0), "1\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
  EXPECT_EQ(WithConvexPieces(bare_)->convex_pieces_O.size(), 1u);
}

TEST_F(CachedPieces, AreRecomputedIfAPieceIsCutShort) {
  const auto made = WithConvexPieces(bare_);
  WriteCacheFile(Files().at(0), "1\n4\n0 0 0\n1 0 0\n0 1");
  EXPECT_EQ(WithConvexPieces(bare_)->convex_pieces_O.size(), made->convex_pieces_O.size());
}

TEST_F(CachedPieces, AreRecomputedIfTheFileIsTruncated) {
  const auto made = WithConvexPieces(bare_);
  std::filesystem::resize_file(Files().at(0), 30);
  EXPECT_EQ(WithConvexPieces(bare_)->convex_pieces_O.size(), made->convex_pieces_O.size());
}

TEST_F(CachedPieces, DependOnTheOptions) {
  WithConvexPieces(bare_);
  DecompositionOptions options;
  options.max_pieces = 2;
  EXPECT_LE(WithConvexPieces(bare_, options)->convex_pieces_O.size(), 2u);
  EXPECT_EQ(Files().size(), 2u);
}

TEST(DecomposeConvex, CoversARealScan) {
  const std::filesystem::path file = PICKBED_TEST_DATA "/meshes/ycb/035_power_drill.obj";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const TriangleMesh mesh = LoadMesh(file);
  const std::vector<ConvexPiece> pieces = DecomposeConvex(mesh);
  EXPECT_GE(pieces.size(), 3u);
  EXPECT_LT(LargestUncovered_m(mesh, pieces), 0.005);
  EXPECT_NEAR(SumOfVolumes(pieces) / UniformMassProperties(mesh, 1).volume_m3, 1, 0.1);
}

}  // namespace
}  // namespace pickbed::tests
