#include "sim/convex/piece_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/mesh_query.h"
#include "sim/convex/convex_hull.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3d;

constexpr int kSamplesOfAll = 4000;  // on the surfaces of all pieces together
constexpr int kSamplesOfOne = 100;   // minimum on one piece
constexpr int kSamplesOfMesh = 4000;

// Settings from coarse to fine. Each step costs about as much as all steps before it.
struct Effort {
  int max_pieces;
  double max_air_share;
};
constexpr std::array<Effort, 4> kEfforts{{{16, 0.02}, {24, 0.01}, {40, 0.004}, {64, 0.001}}};

bool IsOutside(const MeshQuery& query, const Vector3d& p) {
  // A general direction, which is parallel to no edge of usual meshes.
  static const Vector3d kDirection = Vector3d(0.31, 0.52, 0.79).normalized();
  const auto hits = query.AllHits(p, kDirection);
  return std::count_if(hits.begin(), hits.end(),
                       [](const SurfaceHit& hit) { return hit.distance > 0; }) %
             2 ==
         0;
}

TriangleMesh HullMesh(const ConvexHull& hull) {
  TriangleMesh mesh;
  mesh.vertices = hull.vertices;
  mesh.triangles = hull.triangles;
  return mesh;
}

double LargestBulge(const MeshQuery& query, const std::vector<ConvexHull>& hulls) {
  const int samples =
      std::max(kSamplesOfOne, kSamplesOfAll / std::max(1, static_cast<int>(hulls.size())));
  Rng rng(0);
  double largest_m = 0;
  for (const ConvexHull& hull : hulls) {
    for (const Vector3d& p : SampleSurface(HullMesh(hull), samples, rng).points) {
      const double distance_m = query.ClosestPoint(p).distance;
      if (distance_m > largest_m && IsOutside(query, p)) largest_m = distance_m;
    }
  }
  return largest_m;
}

// Returns a lower bound of the distance; it is exact if the nearest point is in a face.
double DistanceOutside(const ConvexHull& hull, const Vector3d& p) {
  double maximum = -1e300;
  for (size_t i = 0; i < hull.triangles.size(); ++i) {
    const Vector3d& n = hull.normals[hull.triangle_faces[i]];
    maximum = std::max(maximum, n.dot(p - hull.vertices[hull.triangles[i][0]]));
  }
  return maximum;
}

double LargestMiss(const TriangleMesh& mesh, const std::vector<ConvexHull>& hulls) {
  Rng rng(0);
  double largest_m = 0;
  for (const Vector3d& p : SampleSurface(mesh, kSamplesOfMesh, rng).points) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const ConvexHull& hull : hulls) {
      nearest_m = std::min(nearest_m, DistanceOutside(hull, p));
      if (nearest_m <= largest_m) break;
    }
    largest_m = std::max(largest_m, nearest_m);
  }
  return largest_m;
}

}  // namespace

PieceQuality MeasurePieces(const TriangleMesh& mesh, const std::vector<ConvexPiece>& pieces) {
  PieceQuality quality;
  std::vector<ConvexHull> hulls;
  double volume_m3 = 0;
  for (const ConvexPiece& piece : pieces) {
    quality.vertices += static_cast<int>(piece.vertices_O.size());
    ConvexHull hull = MakeConvexHull(piece.vertices_O);
    if (hull.vertices.empty()) continue;  // a flat piece covers nothing
    volume_m3 += hull.Volume();
    hulls.push_back(std::move(hull));
  }
  quality.pieces = static_cast<int>(pieces.size());
  quality.volume_error = volume_m3 / UniformMassProperties(mesh, 1).volume_m3 - 1;
  quality.bulge_m = LargestBulge(MeshQuery(mesh), hulls);
  quality.missed_m = LargestMiss(mesh, hulls);
  return quality;
}

FittedPieces FitConvexPieces(const TriangleMesh& mesh, double bulge_diameters) {
  const double wanted_m = bulge_diameters * Diameter(mesh);
  FittedPieces best;
  for (const Effort& effort : kEfforts) {
    FittedPieces fitted;
    fitted.pieces = DecomposeConvex(
        mesh, {.max_pieces = effort.max_pieces, .max_air_share = effort.max_air_share});
    if (fitted.pieces.empty()) break;
    fitted.quality = MeasurePieces(mesh, fitted.pieces);
    if (best.pieces.empty() || fitted.quality.bulge_m < best.quality.bulge_m) {
      best = std::move(fitted);
    }
    if (best.quality.bulge_m <= wanted_m) break;
  }
  return best;
}

}  // namespace pickbed::sim
