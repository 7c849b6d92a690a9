#include "scenes/mesh_io/mesh_join.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/mesh_io/mesh_checks.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

// Gives each face its own three vertices, as a file reader returns them.
TriangleMesh WithUnsharedCorners(const TriangleMesh& mesh) {
  TriangleMesh unshared;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const int first = static_cast<int>(unshared.vertices.size());
    unshared.triangles.emplace_back(first, first + 1, first + 2);
    for (const int i : t) {
      unshared.vertices.push_back(mesh.vertices[i]);
      if (!mesh.normals.empty()) unshared.normals.push_back(mesh.normals[i]);
    }
  }
  return unshared;
}

TEST(WithEqualVerticesJoined, JoinsUnsharedCornersAgain) {
  const TriangleMesh ball = BallShape(0.1, 3);
  const TriangleMesh joined = WithEqualVerticesJoined(WithUnsharedCorners(ball));
  ASSERT_EQ(joined.vertices.size(), ball.vertices.size());
  ASSERT_EQ(joined.normals.size(), ball.vertices.size());
  for (size_t i = 0; i < ball.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(joined.vertices[joined.triangles[i][k]], ball.vertices[ball.triangles[i][k]]);
    }
  }
}

// Each of these meshes has two coincident corners that differ in one attribute and therefore stay
// two vertices.
TEST(WithEqualVerticesJoined, KeepsVerticesWithDifferentAttributes) {
  TriangleMesh pair;
  pair.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  pair.triangles = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(WithEqualVerticesJoined(pair).vertices.size(), 4u);
  TriangleMesh creased = pair, painted = pair, unwrapped = pair, near = pair;
  creased.normals.assign(6, {0, 0, 1});
  creased.normals[3] = {0, 1, 0};
  painted.colors.assign(6, {1, 2, 3});
  painted.colors[3] = {1, 2, 4};
  unwrapped.uvs.assign(6, {0.5, 0.5});
  unwrapped.uvs[3] = {0.5, 0.25};
  near.vertices[3].x() = 1e-9;
  for (const TriangleMesh& mesh : {creased, painted, unwrapped, near}) {
    EXPECT_EQ(WithEqualVerticesJoined(mesh).vertices.size(), 5u);
  }
  pair.vertices[3].x() = -0.0;  // the same position
  EXPECT_EQ(WithEqualVerticesJoined(pair).vertices.size(), 4u);
  EXPECT_FALSE(std::signbit(WithEqualVerticesJoined(pair).vertices[0].x()));
}

TEST(DropFlatNormals, DropsOnlyIfAllAreFlatOrOneIsZero) {
  TriangleMesh box = WithUnsharedCorners(BoxShape({1, 2, 3}));
  for (const Eigen::Vector3d& n : FaceNormals(box)) box.normals.insert(box.normals.end(), 3, n);
  TriangleMesh one_smooth = box, one_zero = BallShape(1, 1);
  one_smooth.normals[7] = Eigen::Vector3d(1, 1, 1).normalized();
  one_zero.normals[3].setZero();
  DropFlatNormals(box);
  DropFlatNormals(one_smooth);
  DropFlatNormals(one_zero);
  EXPECT_TRUE(box.normals.empty());
  EXPECT_FALSE(one_smooth.normals.empty());
  EXPECT_TRUE(one_zero.normals.empty());
}

// A triangle with collinear corners fills the gap beside a longer edge. Without it the mesh would
// be open.
TEST(DropDegenerate, KeepsTheSurfaceClosed) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {1, 2, 3}, {0, 4, 3}, {4, 1, 3}, {0, 1, 4}, {2, 2, 3}};
  DropDegenerate(mesh);
  EXPECT_EQ(mesh.triangles.size(), 6u);
  EXPECT_TRUE(InspectMesh(mesh).watertight());
}

}  // namespace
}  // namespace pickbed::tests
