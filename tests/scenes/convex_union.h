#pragma once

// Distances to a union of convex pieces, by brute force over their vertices.

#include <algorithm>
#include <limits>
#include <vector>

#include "scenes/geometry/mesh_query.h"
#include "scenes/objects/object_model.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

struct HalfSpace {
  Eigen::Vector3d normal;  // unit, outward
  double offset;           // normal . p <= offset inside
};

// All triples of vertices that span a face of the hull. A face with more than three corners occurs
// several times, which is harmless here.
struct HullFaces {
  std::vector<HalfSpace> planes;
  TriangleMesh mesh;
};

inline HullFaces FacesOf(const ConvexPiece& piece) {
  constexpr double kFlat_m = 1e-8;  // the points are rounded to nanometres
  const std::vector<Eigen::Vector3d>& v = piece.vertices_O;
  const int n = static_cast<int>(v.size());
  HullFaces hull;
  hull.mesh.vertices = v;
  const auto add_if_supporting = [&](int a, int b, int c) {
    const Eigen::Vector3d cross = (v[b] - v[a]).cross(v[c] - v[a]);
    if (cross.norm() < 1e-9) return;  // m2; the normal of a sliver is unreliable
    const HalfSpace plane{cross.normalized(), cross.normalized().dot(v[a])};
    for (const Eigen::Vector3d& p : v) {
      if (plane.normal.dot(p) > plane.offset + kFlat_m) return;
    }
    hull.planes.push_back(plane);
    hull.mesh.triangles.emplace_back(a, b, c);
  };
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      for (int c = b + 1; c < n; ++c) {
        add_if_supporting(a, b, c);
        add_if_supporting(a, c, b);
      }
    }
  }
  return hull;
}

class ConvexUnion {
 public:
  explicit ConvexUnion(const std::vector<ConvexPiece>& pieces) {
    for (const ConvexPiece& piece : pieces) {
      hulls_.push_back(FacesOf(piece));
      surfaces_.emplace_back(hulls_.back().mesh);
    }
  }

  // Returns 0 inside, else the distance to the nearest piece, in metres.
  double Distance(const Eigen::Vector3d& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < hulls_.size(); ++i) {
      if (Inside(i, p)) return 0;
      nearest = std::min(nearest, surfaces_[i].ClosestPoint(p).distance);
    }
    return nearest;
  }

 private:
  bool Inside(size_t i, const Eigen::Vector3d& p) const {
    return std::all_of(hulls_[i].planes.begin(), hulls_[i].planes.end(),
                       [&](const HalfSpace& h) { return h.normal.dot(p) <= h.offset; });
  }

  std::vector<HullFaces> hulls_;
  std::vector<MeshQuery> surfaces_;
};

}  // namespace pickbed::tests
