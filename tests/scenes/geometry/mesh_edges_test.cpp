#include "scenes/geometry/mesh_edges.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/layer.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

TEST(MeshEdges, BoxHasTwelveSharpEdgesAndSixDiagonals) {
  const std::vector<MeshEdge> edges = MeshEdges(BoxMesh({0.1, 0.2, 0.3}, Eigen::Vector3d::Zero()));
  EXPECT_EQ(edges.size(), 18u);
  double sharp_m = 0;
  for (const MeshEdge& edge : edges) {
    if (edge.normal_cos() < 0.5) sharp_m += (edge.b - edge.a).norm();
  }
  EXPECT_NEAR(sharp_m, 4 * (0.1 + 0.2 + 0.3), 1e-9);
}

TEST(MeshEdges, EdgeOfOneFaceIsSharp) {
  TriangleMesh triangle;
  triangle.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  const std::vector<MeshEdge> edges = MeshEdges(triangle);
  ASSERT_EQ(edges.size(), 3u);
  for (const MeshEdge& edge : edges) EXPECT_NEAR(edge.normal_cos(), -1, 1e-12);
}

TEST(MeshEdges, VerticesAtOnePlaceAreOneVertex) {
  // Two triangles in one plane that share an edge, each with its own vertices.
  TriangleMesh square;
  square.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::vector<MeshEdge> edges = MeshEdges(square);
  EXPECT_EQ(edges.size(), 5u);
  EXPECT_EQ(std::count_if(edges.begin(), edges.end(),
                          [](const MeshEdge& edge) { return edge.normal_cos() > 0.99; }),
            1);
}

}  // namespace
}  // namespace pickbed::tests
