#include "grasp/candidates/surface_sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

double Nearest(const Eigen::Matrix3Xd& points, const Vector3d& to) {
  return (points.colwise() - to).colwise().norm().minCoeff();
}

// Returns a closed prism over a regular polygon.
TriangleMesh Prism(int corners, double radius_m, double height_m) {
  TriangleMesh mesh;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    for (const double z : {0.0, height_m}) {
      mesh.vertices.push_back({radius_m * std::cos(angle), radius_m * std::sin(angle), z});
    }
  }
  for (int k = 0; k < corners; ++k) {
    const int a = 2 * k, b = 2 * ((k + 1) % corners);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    if (k > 0) {
      mesh.triangles.push_back({0, b, a});
      mesh.triangles.push_back({1, a + 1, b + 1});
    }
  }
  return mesh;
}

TEST(SharpEdgePoints, CoverTheTwelveEdgesOfABox) {
  const Vector3d half(0.03, 0.02, 0.01);
  const double spacing_m = 0.004;
  const Eigen::Matrix3Xd points = SharpEdgePoints(BoxMesh(2 * half, Vector3d::Zero()), spacing_m);
  for (int i = 0; i < points.cols(); ++i) {
    const Eigen::Array3d inside_m = half.array() - points.col(i).array().abs();
    EXPECT_GE(inside_m.minCoeff(), -1e-12);
    EXPECT_GE((inside_m < 1e-9).count(), 2) << "not on an edge: " << points.col(i).transpose();
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      for (double t = -1; t <= 1; t += 0.01) {
        Vector3d on_edge = sign * half;
        on_edge[axis] = t * half[axis];
        EXPECT_LE(Nearest(points, on_edge), spacing_m);
      }
    }
  }
}

TEST(SharpEdgePoints, CylinderHasRimsAndNoSideEdges) {
  const Eigen::Matrix3Xd points = SharpEdgePoints(Prism(64, 0.03, 0.1), 0.002);
  ASSERT_GT(points.cols(), 0);
  for (int i = 0; i < points.cols(); ++i) {
    const double z_m = points(2, i);
    EXPECT_LE(std::min(std::abs(z_m), std::abs(0.1 - z_m)), 1e-9);
  }
}

// A texture seam duplicates vertices, but it is no edge of the object.
TEST(SharpEdgePoints, DuplicateVerticesAreOnePosition) {
  TriangleMesh plate;
  plate.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  plate.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Eigen::Matrix3Xd points = SharpEdgePoints(plate, 0.1);
  EXPECT_GT(Nearest(points, {0.5, 0.5, 0}), 0.3);
  EXPECT_LE(Nearest(points, {0.5, 0, 0}), 0.1) << "a rim edge has only one face";
}

}  // namespace
}  // namespace pickbed::tests
