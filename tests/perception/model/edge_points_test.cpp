#include "perception/model/edge_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/support/layer.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

TEST(EdgePoints, PointsOfABoxAreEvenlyOnItsEdges) {
  const std::vector<EdgePoint> points =
      MakeEdgePoints(BoxMesh({0.1, 0.2, 0.3}, Eigen::Vector3d::Zero()), 240);
  EXPECT_NEAR(static_cast<double>(points.size()), 240, 1);
  const Eigen::Vector3f half(0.05f, 0.1f, 0.15f);
  std::array<int, 3> along{};
  for (const EdgePoint& point : points) {
    const Eigen::Array3f to_side = half.array() - point.p_O.array().abs();
    // On an edge, two coordinates are at a side, and the third is the direction of the edge.
    EXPECT_EQ((to_side.abs() < 1e-6f).count(), 2) << point.p_O.transpose();
    Eigen::Index axis = 0;
    EXPECT_NEAR(point.along_O.cwiseAbs().maxCoeff(&axis), 1, 1e-6);
    EXPECT_GT(to_side[axis], 0);
    EXPECT_NEAR(point.normal_1_O.dot(point.normal_2_O), 0, 1e-6);
    ++along[axis];
  }
  // In proportion to the lengths.
  EXPECT_NEAR(along[0], 40, 4);
  EXPECT_NEAR(along[1], 80, 4);
  EXPECT_NEAR(along[2], 120, 4);
}

TEST(EdgePoints, FoldsUnder45DegreesAreNotSharp) {
  // Points on the fold along x of two triangles that rise by `slope`.
  const auto points_on_fold = [](double slope) {
    TriangleMesh roof;
    roof.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, slope}, {0, -1, slope}};
    roof.triangles = {{0, 1, 2}, {1, 0, 3}};
    const std::vector<EdgePoint> points = MakeEdgePoints(roof, 50);
    EXPECT_NEAR(static_cast<double>(points.size()), 50, 1);
    return std::count_if(points.begin(), points.end(),
                         [](const EdgePoint& point) { return std::abs(point.p_O.y()) < 1e-6f; });
  };
  EXPECT_EQ(points_on_fold(0.1), 0);
  EXPECT_EQ(points_on_fold(0.35), 0) << "39 degrees";
  EXPECT_GT(points_on_fold(0.5), 5) << "53 degrees";
}

}  // namespace
}  // namespace pickbed::tests
