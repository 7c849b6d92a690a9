#include "scenes/geometry/polygon_triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3i;

Outline Polygon(const Vector2d& center, double radius, int count) {
  Outline outline;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    outline.push_back(center + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

Outline AllPoints(const Outline& outer, const std::vector<Outline>& holes) {
  Outline points = outer;
  for (const Outline& hole : holes) points.insert(points.end(), hole.begin(), hole.end());
  return points;
}

double Area(const Outline& points, const Vector3i& t) {
  return SignedArea({points[t[0]], points[t[1]], points[t[2]]});
}

// A triangulation of n points in a polygon with h holes has n + 2 h - 2 triangles. All are
// counter-clockwise and together cover exactly the polygon without its holes.
void ExpectTriangulates(const Outline& outer, const std::vector<Outline>& holes) {
  const Outline points = AllPoints(outer, holes);
  const std::vector<Vector3i> triangles = TriangulatePolygon(outer, holes);
  double expected = std::abs(SignedArea(outer)), sum = 0;
  for (const Outline& hole : holes) expected -= std::abs(SignedArea(hole));
  for (const Vector3i& t : triangles) {
    EXPECT_GT(Area(points, t), 0);
    sum += Area(points, t);
  }
  EXPECT_EQ(triangles.size(), points.size() + 2 * holes.size() - 2);
  EXPECT_NEAR(sum, expected, 1e-9 * expected);
}

TEST(PolygonTriangulation, CoversPolygonsWithAndWithoutHoles) {
  const Outline square = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  const Outline comb = {{0, 0}, {9, 0}, {9, 5}, {8, 1}, {6, 5}, {5, 1}, {3, 5}, {2, 1}, {0, 5}};
  const Outline with_collinear = {{0, 0}, {5, 0}, {10, 0}, {10, 10}, {5, 10}, {0, 10}, {0, 5}};
  ExpectTriangulates(square, {});
  ExpectTriangulates(comb, {});
  ExpectTriangulates(with_collinear, {});
  ExpectTriangulates(square, {Polygon({5, 5}, 3, 24)});
  ExpectTriangulates(square,
                     {Polygon({2, 2}, 1, 7), Polygon({7, 3}, 2, 30), Polygon({4, 8}, 1, 3)});
}

TEST(PolygonTriangulation, AcceptsEitherWinding) {
  const Outline square = {{0, 10}, {10, 10}, {10, 0}, {0, 0}};
  const Outline hole = Polygon({5, 5}, 2, 12);
  ExpectTriangulates(square, {hole});
  ExpectTriangulates(square, {Outline(hole.rbegin(), hole.rend())});
}

TEST(PolygonTriangulation, IsDelaunayInAConvexPolygon) {
  Outline ellipse;
  for (int i = 0; i < 20; ++i) {
    const double angle = 2 * M_PI * (i + 0.1 * (i % 3)) / 20;
    ellipse.emplace_back(4 * std::cos(angle), std::sin(angle));
  }
  for (const Vector3i& t : TriangulatePolygon(ellipse)) {
    const Vector2d &a = ellipse[t[0]], &b = ellipse[t[1]], &c = ellipse[t[2]];
    for (const Vector2d& p : ellipse) {
      Eigen::Matrix3d in_circle;  // determinant > 0: p inside the circle through a, b, c
      in_circle.row(0) << (a - p).transpose(), (a - p).squaredNorm();
      in_circle.row(1) << (b - p).transpose(), (b - p).squaredNorm();
      in_circle.row(2) << (c - p).transpose(), (c - p).squaredNorm();
      EXPECT_LT(in_circle.determinant(), 1e-9);
    }
  }
}

TEST(PolygonTriangulation, RefusesCrossedOutlinesAndHolesOutside) {
  const Outline bow_tie = {{0, 0}, {10, 0}, {10, 10}, {5, -5}, {0, 10}};
  const Outline square = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  EXPECT_THROW(TriangulatePolygon(bow_tie), std::logic_error);
  EXPECT_THROW(TriangulatePolygon(square, {Polygon({40, 5}, 3, 12), Polygon({5, 5}, 3, 12)}),
               std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
