#include "scenes/bin/bin_pieces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "scenes/geometry/mesh_query.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDeepest_m = 0.05;
constexpr double kUpwards = 0.9;      // cosine of the largest slope of a floor
constexpr double kFloor_m = 0.001;    // largest distance of a floor from z = 0
constexpr double kFlat_m = 1e-5;      // a corner's distance from the plane of its region
constexpr double kSameNormal = 1e-7;  // 1 - cosine
constexpr double kSameArea = 1e-4;    // share by which a convex region's hull may be larger
// A corner's depth is measured at this share of the way from the corner to the center.
constexpr double kInset = 0.01;
constexpr double kSurface_m = 1e-7;  // hits nearer than this are the front itself

// Returns groups of connected triangles that are in the plane of the first triangle of the group.
std::vector<std::vector<int>> FlatRegions(const TriangleMesh& mesh,
                                          const std::vector<Vector3d>& normals) {
  std::map<std::pair<int, int>, std::vector<int>> faces_of_edge;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    for (int k = 0; k < 3; ++k) {
      faces_of_edge[std::minmax(int{t[k]}, int{t[(k + 1) % 3]})].push_back(i);
    }
  }
  std::vector<bool> taken(mesh.triangles.size(), false);
  std::vector<std::vector<int>> regions;
  for (int seed = 0; seed < static_cast<int>(mesh.triangles.size()); ++seed) {
    if (taken[seed] || normals[seed].isZero()) continue;
    const Vector3d origin = mesh.vertices[mesh.triangles[seed][0]];
    const auto in_plane = [&](int face) {
      if (normals[face].dot(normals[seed]) < 1 - kSameNormal) return false;
      for (const int v : mesh.triangles[face]) {
        if (std::abs((mesh.vertices[v] - origin).dot(normals[seed])) > kFlat_m) return false;
      }
      return true;
    };
    std::vector<int> region{seed};
    taken[seed] = true;
    for (size_t i = 0; i < region.size(); ++i) {
      const Eigen::Vector3i t = mesh.triangles[region[i]];
      for (int k = 0; k < 3; ++k) {
        for (const int next : faces_of_edge[std::minmax(int{t[k]}, int{t[(k + 1) % 3]})]) {
          if (taken[next] || !in_plane(next)) continue;
          taken[next] = true;
          region.push_back(next);
        }
      }
    }
    regions.push_back(std::move(region));
  }
  return regions;
}

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Returns the ordered corners of the convex hull of points in the plane perpendicular to `normal`
// (Andrew 1979), and its area.
std::vector<Vector3d> FlatHull(std::vector<Vector3d> points, const Vector3d& normal,
                               double& area_m2) {
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const auto flat = [&](const Vector3d& p) { return Vector2d(p.dot(u), p.dot(v)); };
  std::sort(points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
    const Vector2d fa = flat(a), fb = flat(b);
    return std::pair(fa.x(), fa.y()) < std::pair(fb.x(), fb.y());
  });
  std::vector<Vector3d> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const size_t begin = hull.size();
    for (const Vector3d& p : points) {
      while (hull.size() >= begin + 2 && Cross(flat(hull.back()) - flat(hull[hull.size() - 2]),
                                               flat(p) - flat(hull.back())) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();  // the other pass begins with this point
    std::reverse(points.begin(), points.end());
  }
  area_m2 = 0;
  for (size_t i = 1; i + 1 < hull.size(); ++i) {
    area_m2 += 0.5 * Cross(flat(hull[i]) - flat(hull[0]), flat(hull[i + 1]) - flat(hull[0]));
  }
  return hull;
}

// Returns the thickness of the solid under a point of its surface, in m.
double Depth(const MeshQuery& query, const Vector3d& p, const Vector3d& normal) {
  if (normal.z() > kUpwards && std::abs(p.z()) < kFloor_m) return kDeepest_m;
  for (const SurfaceHit& hit : query.AllHits(p, -normal)) {
    if (hit.distance > kSurface_m) return std::min(kDeepest_m, hit.distance);
  }
  return kDeepest_m;
}

std::vector<Vector3d> PieceUnder(const std::vector<Vector3d>& front, const Vector3d& normal,
                                 const MeshQuery& query) {
  Vector3d center = Vector3d::Zero();
  for (const Vector3d& p : front) center += p / static_cast<double>(front.size());
  const double center_m = Depth(query, center, normal);
  std::vector<Vector3d> piece = front;
  for (const Vector3d& p : front) {
    const double depth_m = std::min(center_m, Depth(query, p + kInset * (center - p), normal));
    piece.push_back(p - depth_m * normal);
  }
  return piece;
}

}  // namespace

std::vector<std::vector<Vector3d>> SolidPieces(const TriangleMesh& mesh) {
  const MeshQuery query(mesh);
  const std::vector<Vector3d> normals = FaceNormals(mesh);
  std::vector<std::vector<Vector3d>> pieces;
  for (const std::vector<int>& region : FlatRegions(mesh, normals)) {
    const Vector3d& normal = normals[region[0]];
    std::vector<Vector3d> corners;
    double area_m2 = 0, hull_m2 = 0;
    for (const int face : region) {
      const Eigen::Vector3i& t = mesh.triangles[face];
      for (const int v : t) corners.push_back(mesh.vertices[v]);
      area_m2 += 0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                           .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                           .norm();
    }
    const std::vector<Vector3d> hull = FlatHull(corners, normal, hull_m2);
    if (hull_m2 <= (1 + kSameArea) * area_m2) {
      pieces.push_back(PieceUnder(hull, normal, query));
      continue;
    }
    for (size_t i = 0; i < corners.size(); i += 3) {
      pieces.push_back(PieceUnder({corners[i], corners[i + 1], corners[i + 2]}, normal, query));
    }
  }
  return pieces;
}

}  // namespace pickbed::scenes
