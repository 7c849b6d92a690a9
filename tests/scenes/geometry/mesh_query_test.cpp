#include "scenes/geometry/mesh_query.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Returns random triangles without any order, so that the order of a regular mesh cannot hide an
// error.
TriangleMesh RandomTriangles(int count, Rng& rng) {
  TriangleMesh random_mesh;
  for (int i = 0; i < count; ++i) {
    const Vector3d center = rng.Uniform() * rng.UnitVector();
    for (int k = 0; k < 3; ++k) random_mesh.vertices.push_back(center + 0.1 * rng.UnitVector());
    random_mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return random_mesh;
}

// Independent reference: the closest point in the plane if it is inside the triangle, else on an
// edge.
double DistanceToTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                          const Vector3d& c) {
  const auto to_segment = [&](const Vector3d& s, const Vector3d& e) {
    const double t = std::clamp((p - s).dot(e - s) / (e - s).squaredNorm(), 0.0, 1.0);
    return (s + t * (e - s) - p).norm();
  };
  double distance = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  Eigen::Matrix<double, 3, 2> sides;
  sides << b - a, c - a;
  const Eigen::Vector2d uv = (sides.transpose() * sides).inverse() * sides.transpose() * (p - a);
  if (uv.minCoeff() >= 0 && uv.sum() <= 1) {
    distance = std::min(distance, (a + sides * uv - p).norm());
  }
  return distance;
}

// Returns the sorted t of all solutions of origin + t d = a + u (b - a) + v (c - a) inside a
// triangle.
std::vector<double> BruteForceHits(const TriangleMesh& mesh, const Vector3d& origin,
                                   const Vector3d& direction) {
  std::vector<double> hits;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices[t[0]];
    Eigen::Matrix3d system;
    system << -direction, mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a;
    const Vector3d tuv = system.fullPivLu().solve(origin - a);
    if (tuv.y() >= 0 && tuv.z() >= 0 && tuv.y() + tuv.z() <= 1) hits.push_back(tuv.x());
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

TEST(ClosestPoint, EqualsBruteForceOnRandomTriangles) {
  Rng rng(1);
  for (const int count : {1, 4, 5, 300}) {
    const TriangleMesh random_mesh = RandomTriangles(count, rng);
    const MeshQuery query(random_mesh);
    const std::vector<Vector3d> normals = FaceNormals(random_mesh);
    for (int i = 0; i < 200; ++i) {
      const Vector3d p = 1.5 * rng.Uniform() * rng.UnitVector();
      double nearest = kInfinity;
      for (const Eigen::Vector3i& t : random_mesh.triangles) {
        nearest = std::min(
            nearest, DistanceToTriangle(p, random_mesh.vertices[t[0]], random_mesh.vertices[t[1]],
                                        random_mesh.vertices[t[2]]));
      }
      const SurfaceHit hit = query.ClosestPoint(p);
      EXPECT_NEAR(hit.distance, nearest, 1e-12);
      EXPECT_NEAR((hit.point - p).norm(), nearest, 1e-12);
      const Eigen::Vector3i& t = random_mesh.triangles[hit.triangle];
      EXPECT_NEAR(DistanceToTriangle(hit.point, random_mesh.vertices[t[0]],
                                     random_mesh.vertices[t[1]], random_mesh.vertices[t[2]]),
                  0, 1e-9);
      EXPECT_EQ(hit.normal, normals[hit.triangle]);
    }
  }
}

TEST(ClosestPoint, MatchesTheBoxInsideAndOutside) {
  const MeshQuery query(BoxShape({2, 2, 2}));
  struct {
    Vector3d p;
    double distance;
  } cases[] = {{{0, 0, 0.4}, 0.6},        {{3, 0, 0}, 2}, {{2, 2, 0}, std::sqrt(2)},
               {{2, 2, 2}, std::sqrt(3)}, {{1, 1, 1}, 0}, {{0.2, -5, 0.3}, 4}};
  for (const auto& c : cases) {
    EXPECT_NEAR(query.ClosestPoint(c.p).distance, c.distance, 1e-12) << c.p.transpose();
  }
}

TEST(IsWithin, AgreesExactlyWithTheClosestPoint) {
  Rng rng(3);
  for (const int count : {1, 5, 300}) {
    const MeshQuery query(RandomTriangles(count, rng));
    for (int i = 0; i < 200; ++i) {
      const Vector3d p = 1.5 * rng.Uniform() * rng.UnitVector();
      const double distance = query.ClosestPoint(p).distance;
      EXPECT_TRUE(query.IsWithin(p, distance));
      EXPECT_TRUE(query.IsWithin(p, 2 * distance));
      EXPECT_FALSE(query.IsWithin(p, distance * (1 - 1e-15)));
    }
  }
}

TEST(Raycast, EqualsBruteForceOnRandomTriangles) {
  Rng rng(2);
  const TriangleMesh random_mesh = RandomTriangles(300, rng);
  const MeshQuery query(random_mesh);
  int hits_seen = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3d origin = 2 * rng.UnitVector();
    const Vector3d direction = (0.5 * rng.UnitVector() - origin).normalized();
    const std::vector<double> expected = BruteForceHits(random_mesh, origin, direction);
    const std::vector<SurfaceHit> all = query.AllHits(origin, direction);
    ASSERT_EQ(all.size(), expected.size());
    for (size_t k = 0; k < all.size(); ++k) {
      EXPECT_NEAR(all[k].distance, expected[k], 1e-9);
      EXPECT_NEAR((all[k].point - origin - expected[k] * direction).norm(), 0, 1e-9);
    }
    const auto first = query.Raycast(origin, direction, 0, kInfinity);
    ASSERT_EQ(first.has_value(), !expected.empty());
    if (first) {
      EXPECT_NEAR(first->distance, expected.front(), 1e-9);
    }
    hits_seen += static_cast<int>(expected.size());
  }
  EXPECT_GT(hits_seen, 200);
}

TEST(Raycast, FindsHitsOnlyInItsInterval) {
  const MeshQuery query(BoxShape({2, 2, 2}));
  const Vector3d origin(-3, 0.1, 0.2), direction(1, 0, 0);
  EXPECT_NEAR(query.Raycast(origin, direction, 0, 10)->distance, 2, 1e-12);
  EXPECT_NEAR(query.Raycast(origin, direction, 2.5, 10)->distance, 4, 1e-12);
  EXPECT_FALSE(query.Raycast(origin, direction, 0, 1.9).has_value());
  EXPECT_FALSE(query.Raycast(origin, direction, 4.5, 10).has_value());
  EXPECT_FALSE(query.Raycast(origin, -direction, 0, 10).has_value());
  EXPECT_EQ(query.Raycast(origin, direction, 0, 10)->normal, Vector3d(-1, 0, 0));
}

TEST(AllHits, IncludesHitsBehindTheOriginInOrder) {
  const MeshQuery query(BoxShape({2, 2, 2}));
  const std::vector<SurfaceHit> hits = query.AllHits({0.5, 0.1, 0.2}, {1, 0, 0});
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_NEAR(hits[0].distance, -1.5, 1e-12);
  EXPECT_NEAR(hits[1].distance, 0.5, 1e-12);
}

// A line through the diagonal that two triangles of a box face share still has two hits.
TEST(AllHits, CountsASharedEdgeOnce) {
  const MeshQuery query(BoxShape({2, 2, 2}));
  for (const double offset : {0.0, 0.25, -0.5}) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d direction = Vector3d::Unit(axis);
      for (const double sign : {-1.0, 1.0}) {
        Vector3d origin = Vector3d::Constant(offset);
        origin[(axis + 1) % 3] *= sign;
        origin[axis] = -5;
        EXPECT_EQ(query.AllHits(origin, direction).size(), 2u) << axis << " " << offset;
      }
    }
  }
}

TEST(Raycast, DoesNotPassThroughVerticesAndEdges) {
  const TriangleMesh ball = BallShape(0.05, 4);
  const MeshQuery query(ball);
  for (const Eigen::Vector3i& t : ball.triangles) {
    const Vector3d& a = ball.vertices[t[0]];
    const Vector3d side = 0.5 * (ball.vertices[t[1]] + ball.vertices[t[2]]);
    const Vector3d inside(0.001, 0.002, 0.003);
    for (const Vector3d& target : {a, side}) {
      EXPECT_TRUE(query.Raycast(Vector3d::Zero(), target.normalized(), 0, 1).has_value());
      EXPECT_TRUE(query.Raycast(inside, (target - inside).normalized(), 0, 1).has_value());
    }
  }
}

TEST(MeshQuery, MatchesTheBallFormula) {
  const double radius = 0.1;
  const MeshQuery query(BallShape(radius, 6));
  Rng rng(3);
  for (int i = 0; i < 300; ++i) {
    const Vector3d p = 0.3 * rng.UnitVector();
    EXPECT_NEAR(query.ClosestPoint(p).distance, 0.2, 1e-4);
    const Vector3d target = 0.09 * rng.Uniform() * rng.UnitVector();
    const Vector3d direction = (target - p).normalized();
    const double along = -p.dot(direction);
    const double half_chord = std::sqrt(radius * radius - (p.squaredNorm() - along * along));
    const std::vector<SurfaceHit> hits = query.AllHits(p, direction);
    ASSERT_EQ(hits.size(), 2u);
    EXPECT_NEAR(hits[0].distance, along - half_chord, 5e-4);
    EXPECT_NEAR(hits[1].distance, along + half_chord, 5e-4);
    EXPECT_LT(hits[0].normal.dot(direction), 0);
    EXPECT_GT(hits[1].normal.dot(direction), 0);
  }
}

TEST(MeshQuery, IgnoresZeroAreaFacesAndCanBeMoved) {
  TriangleMesh box = BoxShape({2, 2, 2});
  box.triangles.insert(box.triangles.begin(), {0, 0, 1});
  MeshQuery query(box);
  const MeshQuery moved = std::move(query);
  EXPECT_NEAR(moved.ClosestPoint({-1, -1, -3}).distance, 2, 1e-12);
  EXPECT_GT(moved.ClosestPoint({-1, -1, -3}).triangle, 0);
  InputErrorOf([] { MeshQuery({}); });
}

}  // namespace
}  // namespace pickbed::tests
