#include "perception/model/edge_points.h"

#include <algorithm>
#include <cmath>

#include "scenes/geometry/mesh_edges.h"

namespace pickbed::perception {

std::vector<EdgePoint> MakeEdgePoints(const TriangleMesh& mesh, int max_points) {
  constexpr double kSharpCos = 0.7;
  std::vector<MeshEdge> sharp;
  double length_m = 0;
  for (const MeshEdge& edge : MeshEdges(mesh)) {
    if (edge.normal_cos() > kSharpCos) continue;
    sharp.push_back(edge);
    length_m += (edge.b - edge.a).norm();
  }
  // One point per step along the chain of all edges.
  std::vector<EdgePoint> points;
  const double step_m = length_m / max_points;
  double next_m = 0.5 * step_m;  // from the start of the edge
  for (const MeshEdge& edge : sharp) {
    const double edge_m = (edge.b - edge.a).norm();
    for (; next_m < edge_m; next_m += step_m) {
      const Eigen::Vector3d along = (edge.b - edge.a) / edge_m;
      points.push_back({(edge.a + next_m * along).cast<float>(), along.cast<float>(),
                        edge.normal_1.cast<float>(), edge.normal_2.cast<float>()});
    }
    next_m -= edge_m;
  }
  return points;
}

}  // namespace pickbed::perception
