#include "scenes/geometry/triangle_mesh.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

double BruteForceDiameter(const std::vector<Vector3d>& points) {
  double squared = 0;
  for (const Vector3d& a : points) {
    for (const Vector3d& b : points) squared = std::max(squared, (a - b).squaredNorm());
  }
  return std::sqrt(squared);
}

TEST(Diameter, EqualsBruteForce) {
  Rng rng(1);
  for (const int count : {1, 2, 3, 17, 33, 500, 3000}) {
    for (const Vector3d& stretch : {Vector3d(1, 1, 1), Vector3d(10, 1, 0), Vector3d(0, 0, 3)}) {
      TriangleMesh ball, sphere, equal;
      for (int i = 0; i < count; ++i) {
        const Vector3d p = rng.UnitVector().cwiseProduct(stretch);
        sphere.vertices.push_back(p);
        ball.vertices.push_back(rng.Uniform() * p + Vector3d(5, 5, 5));
        equal.vertices.push_back({1, 2, 3});
      }
      EXPECT_EQ(Diameter(sphere), BruteForceDiameter(sphere.vertices)) << count;
      EXPECT_EQ(Diameter(ball), BruteForceDiameter(ball.vertices)) << count;
      EXPECT_EQ(Diameter(equal), 0) << count;
    }
  }
  EXPECT_EQ(Diameter({}), 0);
  EXPECT_NEAR(Diameter(BoxShape({1, 2, 2})), 3, 1e-12);
}

// In some of these small clouds, repeated jumps to the farthest point end before the farthest pair.
TEST(Diameter, IsTheGlobalMaximum) {
  Rng rng(7);
  for (int trial = 0; trial < 500; ++trial) {
    TriangleMesh cloud;
    for (int i = 0; i < 60; ++i) cloud.vertices.push_back(rng.UnitVector());
    ASSERT_EQ(Diameter(cloud), BruteForceDiameter(cloud.vertices)) << trial;
  }
}

TEST(MeshBounds, AreTightAndZeroForAnEmptyMesh) {
  const Bounds bounds = MeshBounds(BoxShape({1, 2, 3}, {10, 20, 30}));
  EXPECT_TRUE(bounds.size().isApprox(Vector3d(1, 2, 3)));
  EXPECT_TRUE(bounds.center().isApprox(Vector3d(10, 20, 30)));
  EXPECT_EQ(MeshBounds({}).size(), Vector3d::Zero());
}

TEST(SurfaceArea, MatchesBoxAndBall) {
  EXPECT_NEAR(SurfaceArea(BoxShape({1, 2, 3})), 22, 1e-12);
  EXPECT_NEAR(SurfaceArea(BallShape(0.1, 5)), 4 * std::numbers::pi * 0.01, 1e-4);
}

TEST(FaceNormals, PointOutwardsAndAreZeroWithoutArea) {
  TriangleMesh ball = BallShape(2, 3);
  ball.triangles.emplace_back(0, 0, 1);
  const std::vector<Vector3d> normals = FaceNormals(ball);
  EXPECT_EQ(normals.back(), Vector3d::Zero());
  for (size_t i = 0; i + 1 < normals.size(); ++i) {
    const Vector3d& corner = ball.vertices[ball.triangles[i][0]];
    EXPECT_NEAR(normals[i].norm(), 1, 1e-12);
    EXPECT_GT(normals[i].dot(corner.normalized()), 0.9);
  }
}

TEST(Transformed, RoundTripsAndOnlyRotatesNormals) {
  Rng rng(2);
  const TriangleMesh ball = BallShape(1, 2);
  const Pose X_AB = MakePose(rng.Rotation().toRotationMatrix(), {1, 2, 3});
  const TriangleMesh moved = Transformed(ball, X_AB);
  const TriangleMesh back = Transformed(moved, X_AB.inverse());
  for (size_t i = 0; i < ball.vertices.size(); ++i) {
    EXPECT_LT((moved.normals[i] - X_AB.linear() * ball.normals[i]).norm(), 1e-12);
    EXPECT_LT((back.vertices[i] - ball.vertices[i]).norm(), 1e-12);
    EXPECT_LT((back.normals[i] - ball.normals[i]).norm(), 1e-12);
  }
}

TEST(Scaled, ScalesLengthsAndRefusesReflections) {
  EXPECT_NEAR(Diameter(Scaled(BoxShape({1, 2, 2}), 0.1)), 0.3, 1e-12);
  EXPECT_THROW(Scaled(BoxShape({1, 2, 2}), -1), std::invalid_argument);
}

TEST(Append, AddsFacesAndKeepsAttributesOfBoth) {
  TriangleMesh mesh;
  Append(BallShape(1, 1), mesh);
  EXPECT_FALSE(mesh.normals.empty());
  const size_t vertices = mesh.vertices.size();
  Append(BallShape(1, 0), mesh);
  EXPECT_EQ(mesh.vertices.size(), vertices + 6);
  EXPECT_EQ(mesh.normals.size(), vertices + 6);
  EXPECT_EQ(mesh.triangles.back(), BallShape(1, 0).triangles.back() +
                                       Eigen::Vector3i::Constant(static_cast<int>(vertices)));
  Append(BoxShape({1, 1, 1}), mesh);  // without normals
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_NEAR(SurfaceArea(mesh), SurfaceArea(BallShape(1, 1)) + SurfaceArea(BallShape(1, 0)) + 6,
              1e-12);
}

TEST(Append, ConvertsDifferentBaseColorsToVertexColors) {
  TriangleMesh red = BoxShape({1, 1, 1}), blue = BoxShape({1, 1, 1});
  red.base_color = {255, 0, 0};
  blue.base_color = {0, 0, 255};
  TriangleMesh both = red;
  Append(red, both);
  EXPECT_TRUE(both.colors.empty());
  Append(blue, both);
  ASSERT_EQ(both.colors.size(), both.vertices.size());
  EXPECT_EQ(both.colors.front(), red.base_color);
  EXPECT_EQ(both.colors.back(), blue.base_color);
}

TEST(Append, KeepsUvsOnlyForTheSameTexture) {
  TriangleMesh a = BoxShape({1, 1, 1});
  a.uvs.assign(8, {0.5, 0.5});
  a.texture = Image<Rgb8>(2, 2, {1, 2, 3});
  TriangleMesh same = a, other = a;
  Append(a, same);
  EXPECT_EQ(same.uvs.size(), 16u);
  EXPECT_FALSE(same.texture.empty());
  other.texture = Image<Rgb8>(2, 2, {9, 9, 9});
  Append(other, same);
  EXPECT_TRUE(same.uvs.empty());
  EXPECT_TRUE(same.texture.empty());
}

TEST(SampleSurface, IsUniformAndOnTheReturnedTriangle) {
  const TriangleMesh box = BoxShape({1, 2, 3});
  Rng rng(3);
  constexpr int kCount = 20000;
  const SurfaceSamples samples = SampleSurface(box, kCount, rng);
  ASSERT_EQ(samples.points.size(), static_cast<size_t>(kCount));
  const std::vector<Vector3d> normals = FaceNormals(box);
  Vector3d mean = Vector3d::Zero();
  int on_largest = 0;  // the two faces of 2 x 3, 12 of 22
  for (int i = 0; i < kCount; ++i) {
    const Vector3d& n = samples.normals[i];
    ASSERT_EQ(n, normals[samples.triangles[i]]);
    const Vector3d& corner = box.vertices[box.triangles[samples.triangles[i]][0]];
    ASSERT_NEAR((samples.points[i] - corner).dot(n), 0, 1e-12);
    ASSERT_LE((samples.points[i].cwiseAbs() - Vector3d(0.5, 1, 1.5)).maxCoeff(), 1e-12);
    mean += samples.points[i] / kCount;
    on_largest += std::abs(n.x()) > 0.5;
  }
  EXPECT_LT(mean.norm(), 5 * 1.5 / std::sqrt(kCount));
  const double p = 12.0 / 22;
  EXPECT_NEAR(on_largest / double{kCount}, p, 5 * std::sqrt(p * (1 - p) / kCount));
}

TEST(SampleSurface, IsUniformWithinATriangle) {
  TriangleMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  Rng rng(4);
  constexpr int kCount = 20000;
  int near_corner[3] = {};  // each of the three similar corner triangles has 1/4 of the area
  for (const Vector3d& p : SampleSurface(one, kCount, rng).points) {
    near_corner[0] += p.x() + p.y() < 0.5;
    near_corner[1] += p.x() > 0.5;
    near_corner[2] += p.y() > 0.5;
  }
  for (const int n : near_corner) EXPECT_NEAR(n / double{kCount}, 0.25, 0.0153);
}

TEST(SampleSurface, RepeatsForASeedAndRefusesAnEmptyMesh) {
  const TriangleMesh ball = BallShape(1, 2);
  Rng a(5), b(5);
  EXPECT_EQ(SampleSurface(ball, 100, a).points, SampleSurface(ball, 100, b).points);
  InputErrorOf([&] { SampleSurface({}, 1, a); });
}

TEST(MeshHash, DependsOnGeometryButNotOnColor) {
  TriangleMesh mesh = BallShape(1, 2), colored = mesh;
  colored.base_color = {1, 2, 3};
  colored.normals.clear();
  EXPECT_EQ(MeshHash(mesh), MeshHash(colored));
  TriangleMesh moved = mesh, flipped = mesh;
  moved.vertices[3].x() = std::nextafter(moved.vertices[3].x(), 2.0);
  std::swap(flipped.triangles[0][1], flipped.triangles[0][2]);
  EXPECT_NE(MeshHash(mesh), MeshHash(moved));
  EXPECT_NE(MeshHash(mesh), MeshHash(flipped));
}

}  // namespace
}  // namespace pickbed::tests
