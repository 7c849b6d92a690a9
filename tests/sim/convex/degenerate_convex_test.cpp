// Convex hulls, cuts, columns and pieces of degenerate points and meshes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "scenes/base/error.h"
#include "sim/convex/convex_cuts.h"
#include "sim/convex/convex_hull.h"
#include "sim/convex/convex_pieces.h"
#include "sim/convex/piece_quality.h"
#include "sim/convex/solid_columns.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite_m = std::numeric_limits<double>::infinity();

// The degenerate meshes and a plate that is flat, but not along a coordinate axis.
std::vector<DegenerateMesh> MeshesToCut() {
  std::vector<DegenerateMesh> meshes = DegenerateMeshes();
  meshes.push_back(
      {"a tilted plate",
       MeshOf({{0, 0, 0}, {0.1, 0.02, 0.03}, {0.01, 0.1, 0.05}}, {{0, 1, 2}, {0, 2, 1}}), true});
  return meshes;
}

// All solid meshes among the degenerate ones are boxes.
double VolumeOfBox(const TriangleMesh& mesh) { return MeshBounds(mesh).size().prod(); }

struct PointsCase {
  const char* name;
  std::vector<Vector3d> points;
  bool has_volume = false;
};

TEST(DegenerateConvexHull, IsEmptyWithoutAVolume) {
  const Vector3d a(0, 0, 0), b(0.1, 0, 0), c(0, 0.1, 0), d(0, 0, 0.1);
  const PointsCase cases[] = {{"none", {}},
                              {"one point", {a}},
                              {"one point often", std::vector<Vector3d>(50, b)},
                              {"two points", {a, b}},
                              {"a line", {a, b, 2 * b, 3 * b, 4 * b}},
                              {"three points", {a, b, c}},
                              {"a plane", {a, b, c, b + c, 0.5 * (b + c)}},
                              {"a tetrahedron", {a, b, c, d}, true},
                              {"its corners twice", {a, b, c, d, a, b, c, d}, true},
                              {"with points on its faces", {a, b, c, d, 0.5 * b, 0.3 * c}, true}};
  for (const PointsCase& test : cases) {
    const ConvexHull hull = MakeConvexHull(test.points);
    EXPECT_EQ(hull.vertices.size() >= 4, test.has_volume) << test.name;
    EXPECT_EQ(hull.Volume() > 0, test.has_volume) << test.name;
    for (const Vector3d& n : hull.normals) EXPECT_NEAR(n.norm(), 1, 1e-9) << test.name;
  }
}

// Bullet rounds points to integers, which has no meaning for these points.
TEST(DegenerateConvexHull, PointsThatAreNotFiniteAreRefused) {
  for (const double value : {kNotANumber, kInfinite_m, -kInfinite_m}) {
    std::vector<Vector3d> points = BoxShape({0.1, 0.2, 0.3}).vertices;
    points[5].x() = value;
    EXPECT_THAT(ErrorOf([&] { MakeConvexHull(points); }), HasSubstr("not finite"));
  }
}

TEST(DegenerateCuts, OnlyMeshesWithAVolumeHavePieces) {
  for (const DegenerateMesh& test : MeshesToCut()) {
    const std::vector<std::vector<Vector3d>> pieces = CutByPlanes(test.mesh, {});
    EXPECT_EQ(!pieces.empty(), test.has_volume) << test.name;
    const Bounds bounds = MeshBounds(test.mesh);
    const Vector3d slack = Vector3d::Constant(1e-9 * bounds.size().norm());
    const Eigen::AlignedBox3d box(bounds.min - slack, bounds.max + slack);
    for (const std::vector<Vector3d>& points : pieces) {
      EXPECT_GE(points.size(), 4u) << test.name;
      for (const Vector3d& p : points) EXPECT_TRUE(box.contains(p)) << test.name;
    }
  }
}

TEST(DegenerateCuts, VerticesThatAreNotFiniteAreRefused) {
  for (const double value : {kNotANumber, kInfinite_m}) {
    for (size_t i = 0; i < 8; ++i) {
      TriangleMesh mesh = BoxShape({0.1, 0.2, 0.3});
      mesh.vertices[i].z() = value;
      EXPECT_THAT(ErrorOf([&] { CutByPlanes(mesh, {}); }), HasSubstr("not finite"));
      EXPECT_THAT(ErrorOf([&] { DecomposeConvex(mesh); }), HasSubstr("not finite"));
    }
  }
}

TEST(DegenerateColumns, VolumeIsExactForBoxesAndZeroWithoutAVolume) {
  for (const DegenerateMesh& test : MeshesToCut()) {
    const Bounds bounds = MeshBounds(test.mesh);
    const double volume_m3 = test.has_volume ? VolumeOfBox(test.mesh) : 0;
    const Eigen::AlignedBox3d whole(bounds.min, bounds.max);
    for (const int resolution : {1, 2, 64}) {
      const SolidColumns columns(test.mesh, resolution);
      if (resolution == 64) {
        EXPECT_NEAR(columns.VolumeIn(whole), volume_m3, 1e-6 * volume_m3 + 1e-18) << test.name;
      }
      EXPECT_TRUE(std::isfinite(columns.VolumeIn(whole))) << test.name;
      EXPECT_EQ(columns.VolumeIn({}), 0) << test.name;
      EXPECT_EQ(columns.VolumeIn({bounds.max, bounds.max}), 0) << test.name;
      const Vector3d beside(3 * bounds.size().norm() + 1, 0, 0);
      EXPECT_EQ(columns.VolumeIn({bounds.min + beside, bounds.max + beside}), 0) << test.name;
    }
  }
}

// The line through the center of a box meets the diagonals of its faces.
TEST(DegenerateColumns, OnlySolidsHaveAnInside) {
  for (const DegenerateMesh& test : MeshesToCut()) {
    const Bounds bounds = MeshBounds(test.mesh);
    EXPECT_EQ(IsInside(test.mesh, bounds.center()), test.has_volume) << test.name;
    const Vector3d far = bounds.max + Vector3d::Constant(1);
    EXPECT_FALSE(IsInside(test.mesh, far)) << test.name;
    for (int axis = 0; axis < 3; ++axis) {
      Vector3d point = bounds.center();
      point[axis] = kNotANumber;
      EXPECT_FALSE(IsInside(test.mesh, point)) << test.name;
      point[axis] = kInfinite_m;
      EXPECT_FALSE(IsInside(test.mesh, point)) << test.name;
    }
  }
}

TEST(DegenerateConvexPieces, MeshesWithoutVolumeAreRefused) {
  for (const DegenerateMesh& test : MeshesToCut()) {
    try {
      const std::vector<ConvexPiece> pieces = DecomposeConvex(test.mesh);
      EXPECT_TRUE(test.has_volume || pieces.empty()) << test.name;
      EXPECT_TRUE(!test.has_volume || !pieces.empty()) << test.name;
      for (const ConvexPiece& piece : pieces) {
        for (const Vector3d& v : piece.vertices_O) EXPECT_TRUE(v.allFinite()) << test.name;
      }
    } catch (const InputError&) {
      EXPECT_FALSE(test.has_volume) << test.name;
    }
  }
}

TEST(DegenerateConvexPieces, ObjectsWithoutVolumeAreRefusedByName) {
  const TemporaryFolder cache;
  setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  EXPECT_TRUE(WithConvexPieces(ObjectSet()).empty());
  for (const DegenerateMesh& test : MeshesToCut()) {
    const auto object = std::make_shared<ObjectModel>();
    object->name = "thing";
    object->mesh_O = test.mesh;
    object->mesh_hash = MeshHash(test.mesh);
    if (test.has_volume) {
      EXPECT_FALSE(WithConvexPieces(object)->convex_pieces_O.empty()) << test.name;
      continue;
    }
    EXPECT_THAT(ErrorOf([&] { WithConvexPieces(object); }),
                HasSubstr("object 'thing' is flat: its mesh encloses no volume"))
        << test.name;
  }
  unsetenv("XDG_CACHE_HOME");
}

// `object add` must not write pieces that a run refuses.
TEST(DegenerateConvexPieces, AFoilHasNoPieces) {
  for (const double thickness_m : {1e-3, 5e-5, 5e-6, 5e-7}) {
    const auto pieces = DecomposeConvex(BoxShape({0.08, 0.05, thickness_m}));
    EXPECT_EQ(pieces.size(), thickness_m > 2e-4 * 0.08 ? 1u : 0u) << thickness_m;
  }
}

TEST(DegeneratePieceQuality, MeshesWithoutVolumeAreRefused) {
  const std::vector<ConvexPiece> box{{BoxShape({0.1, 0.2, 0.3}).vertices}};
  for (const DegenerateMesh& test : MeshesToCut()) {
    if (test.has_volume) continue;
    EXPECT_THAT(ErrorOf([&] { MeasurePieces(test.mesh, box); }),
                HasSubstr("encloses no positive volume"))
        << test.name;
  }
}

// A piece without a volume covers nothing, as if it were absent.
TEST(DegeneratePieceQuality, FlatPiecesCoverNothing) {
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3});
  const Vector3d a(0, 0, 0), b(0.05, 0, 0), c(0, 0.05, 0);
  const ConvexPiece whole{box.vertices};
  for (const ConvexPiece& flat : {ConvexPiece(), ConvexPiece{{a}}, ConvexPiece{{b, b, b, b}},
                                  ConvexPiece{{a, b, 2 * b, -b}}, ConvexPiece{{a, b, c, b + c}}}) {
    const PieceQuality alone = MeasurePieces(box, {flat});
    EXPECT_EQ(alone.pieces, 1);
    EXPECT_EQ(alone.vertices, static_cast<int>(flat.vertices_O.size()));
    EXPECT_EQ(alone.volume_error, -1);
    EXPECT_EQ(alone.bulge_m, 0);
    EXPECT_EQ(alone.missed_m, kInfinite_m);
    const PieceQuality both = MeasurePieces(box, {flat, whole});
    EXPECT_NEAR(both.volume_error, 0, 1e-9);
    EXPECT_NEAR(both.bulge_m, 0, 1e-9);
    EXPECT_NEAR(both.missed_m, 0, 1e-9);
  }
  EXPECT_EQ(MeasurePieces(box, {}).missed_m, kInfinite_m);
  EXPECT_EQ(MeasurePieces(box, {}).volume_error, -1);
}

TEST(DegenerateConvexPieces, FitIsExactForBoxesAndEmptyWithoutAVolume) {
  for (const DegenerateMesh& test : MeshesToCut()) {
    const FittedPieces fitted = FitConvexPieces(test.mesh);
    EXPECT_EQ(fitted.quality.pieces, test.has_volume ? 1 : 0) << test.name;
    ASSERT_EQ(fitted.pieces.size(), static_cast<size_t>(fitted.quality.pieces)) << test.name;
    const double size_m = Diameter(test.mesh);
    EXPECT_NEAR(fitted.quality.bulge_m, 0, 1e-9 * size_m) << test.name;
    EXPECT_NEAR(fitted.quality.missed_m, 0, 1e-9 * size_m) << test.name;
    EXPECT_NEAR(fitted.quality.volume_error, 0, 1e-6) << test.name;
  }
}

}  // namespace
}  // namespace pickbed::tests
