#include "sim/drop/penetration.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "sim/convex/convex_hull.h"

namespace pickbed::sim {
namespace {

// Thickness of the floor slab. It is so thick that a body deep in the floor does not count as below
// it.
constexpr double kFloorSlab_m = 1.0;
constexpr double kFloorTop_m = 1e-5;
// Edge pairs whose directions differ by a smaller sine give no candidate axis.
constexpr double kParallelSine = 1e-9;

struct PlacedHull {
  ConvexHull hull;  // in frame W
  // For each edge: cross product of its right and left face normals, parallel to the edge.
  std::vector<Eigen::Vector3d> arcs;
  int owner = 0;  // index of the scene object; kBinOwner = bin
  Eigen::AlignedBox3d box;
};
constexpr int kBinOwner = -1;

PlacedHull Place(const ConvexHull& hull_O, const Pose& X_WO, int owner) {
  PlacedHull placed{hull_O, {}, owner, {}};
  for (Eigen::Vector3d& p : placed.hull.vertices) {
    p = X_WO * p;
    placed.box.extend(p);
  }
  for (Eigen::Vector3d& n : placed.hull.normals) n = X_WO.linear() * n;
  for (const ConvexHull::Edge& edge : placed.hull.edges) {
    placed.arcs.push_back(placed.hull.normals[edge.right].cross(placed.hull.normals[edge.left]));
  }
  return placed;
}

// Extends a piece that is entirely below the floor plane further down.
void DeepenFloor(std::vector<Eigen::Vector3d>& corners) {
  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  for (const Eigen::Vector3d& p : corners) {
    top = std::max(top, p.z());
    bottom = std::min(bottom, p.z());
  }
  if (top > kFloorTop_m) return;
  for (Eigen::Vector3d& p : corners) {
    if (p.z() < 0.5 * (top + bottom)) p.z() = -kFloorSlab_m;
  }
}

double Support(const ConvexHull& hull, const Eigen::Vector3d& direction) {
  double maximum = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : hull.vertices) maximum = std::max(maximum, p.dot(direction));
  return maximum;
}

// Returns the gap along a unit direction from a to b. Negative = overlap.
double Gap(const ConvexHull& a, const ConvexHull& b, const Eigen::Vector3d& direction) {
  return -Support(b, -direction) - Support(a, direction);
}

// Returns whether edge i of a and edge k of b span a face of the Minkowski difference. They do if
// the arcs between their face normals (negated for b) cross on the unit sphere.
bool ArcsCross(const PlacedHull& a, int i, const PlacedHull& b, int k) {
  const ConvexHull::Edge& edge_a = a.hull.edges[i];
  const ConvexHull::Edge& edge_b = b.hull.edges[k];
  const double b_left = b.hull.normals[edge_b.left].dot(a.arcs[i]);
  const double b_right = b.hull.normals[edge_b.right].dot(a.arcs[i]);
  if (b_left * b_right >= 0) return false;
  const double a_left = a.hull.normals[edge_a.left].dot(b.arcs[k]);
  const double a_right = a.hull.normals[edge_a.right].dot(b.arcs[k]);
  return a_left * a_right < 0 && b_left * a_right < 0;  // the latter: same hemisphere
}

// Returns the overlap depth of two hulls if it is more than `known_m`, else `known_m`. The search
// stops at the first axis with less overlap than `known_m`.
double Depth(const PlacedHull& a, const PlacedHull& b, double known_m) {
  double gap = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& normal : a.hull.normals) {
    gap = std::max(gap, Gap(a.hull, b.hull, normal));
    if (gap >= -known_m) return known_m;
  }
  for (const Eigen::Vector3d& normal : b.hull.normals) {
    gap = std::max(gap, Gap(a.hull, b.hull, -normal));
    if (gap >= -known_m) return known_m;
  }
  for (size_t i = 0; i < a.hull.edges.size(); ++i) {
    const ConvexHull::Edge& edge_a = a.hull.edges[i];
    const Eigen::Vector3d along_a = a.hull.vertices[edge_a.to] - a.hull.vertices[edge_a.from];
    const Eigen::Vector3d outward = a.hull.normals[edge_a.left] + a.hull.normals[edge_a.right];
    for (size_t k = 0; k < b.hull.edges.size(); ++k) {
      if (!ArcsCross(a, static_cast<int>(i), b, static_cast<int>(k))) continue;
      const ConvexHull::Edge& edge_b = b.hull.edges[k];
      const Eigen::Vector3d along_b = b.hull.vertices[edge_b.to] - b.hull.vertices[edge_b.from];
      Eigen::Vector3d axis = along_a.cross(along_b);
      if (axis.norm() < kParallelSine * along_a.norm() * along_b.norm()) continue;
      axis.normalize();
      if (axis.dot(outward) < 0) axis = -axis;
      gap = std::max(gap, Gap(a.hull, b.hull, axis));
      if (gap >= -known_m) return known_m;
    }
  }
  return -gap;
}

std::vector<PlacedHull> PlaceAll(const Scene& scene, const ObjectSet& objects) {
  std::vector<std::vector<ConvexHull>> hulls_O(objects.size());
  for (size_t i = 0; i < objects.size(); ++i) {
    for (const ConvexPiece& piece : objects[i]->convex_pieces_O) {
      hulls_O[i].push_back(MakeConvexHull(piece.vertices_O));
    }
  }
  std::vector<PlacedHull> placed;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& object = scene.objects[i];
    for (const ConvexHull& hull : hulls_O[object.object]) {
      placed.push_back(Place(hull, object.X_WO, static_cast<int>(i)));
    }
  }
  for (std::vector<Eigen::Vector3d>& corners : BinPieces(scene.bin)) {
    DeepenFloor(corners);
    const ConvexHull hull = MakeConvexHull(corners);
    if (hull.vertices.empty()) continue;  // a sliver of the bin's mesh
    placed.push_back(Place(hull, Pose::Identity(), kBinOwner));
  }
  return placed;
}

// Visits the pairs of pieces of two owners whose boxes meet.
template <typename Visit>
void ForEachMeetingPair(const Scene& scene, const ObjectSet& objects, const Visit& visit) {
  std::vector<PlacedHull> hulls = PlaceAll(scene, objects);
  std::sort(hulls.begin(), hulls.end(), [](const PlacedHull& a, const PlacedHull& b) {
    return a.box.min().x() < b.box.min().x();
  });
  for (size_t i = 0; i < hulls.size(); ++i) {  // sweep along x
    for (size_t k = i + 1; k < hulls.size(); ++k) {
      if (hulls[k].box.min().x() > hulls[i].box.max().x()) break;
      if (hulls[i].owner == hulls[k].owner || !hulls[i].box.intersects(hulls[k].box)) continue;
      visit(hulls[i], hulls[k]);
    }
  }
}

}  // namespace

double DeepestPenetration(const Scene& scene, const ObjectSet& objects) {
  double deepest_m = 0;
  ForEachMeetingPair(scene, objects, [&](const PlacedHull& a, const PlacedHull& b) {
    deepest_m = Depth(a, b, deepest_m);
  });
  return deepest_m;
}

std::vector<Overlap> OverlapsDeeperThan(double limit_m, const Scene& scene,
                                        const ObjectSet& objects) {
  std::set<std::pair<int, int>> pairs;
  ForEachMeetingPair(scene, objects, [&](const PlacedHull& a, const PlacedHull& b) {
    if (Depth(a, b, limit_m) <= limit_m) return;
    const auto [low, high] = std::minmax(a.owner, b.owner);
    pairs.insert(low == kBinOwner ? std::pair(high, low) : std::pair(low, high));
  });
  std::vector<Overlap> overlaps;
  for (const auto& [first, second] : pairs) overlaps.push_back({first, second});
  return overlaps;
}

}  // namespace pickbed::sim
