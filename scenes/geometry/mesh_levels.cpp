#include "scenes/geometry/mesh_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "scenes/base/math.h"
#include "scenes/geometry/edge_collapse.h"
#include "scenes/geometry/mesh_query.h"

namespace pickbed::scenes {
namespace {

constexpr size_t kMinTriangles = 64;  // with fewer, a draw call costs more than its triangles
constexpr double kFirstTolerance_m = 1e-4;
constexpr double kMaxToleranceShare = 0.02;  // of the bounding box's diagonal
constexpr double kMinSaving = 0.25;          // share of triangles that a level must save
constexpr int kDeviationSamples = 2000;      // of each surface
// Weight of short edges in ReducedMesh(): an edge costs like a deviation of 1/1000 of its length.
constexpr double kLengthWeight = 1e-6;
const double kCreaseCosine = std::cos(Radians(40));

// Vertices joined by place and, if there is a texture, by uv. Vertices on texture seams are locked.
struct Joined {
  std::vector<int> original;  // index of one original vertex for each joined vertex
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<bool> locked;
};

Joined Join(const TriangleMesh& mesh) {
  const bool textured = !mesh.texture.empty() && !mesh.uvs.empty();
  Joined out;
  std::map<std::array<double, 5>, int> known;
  std::map<std::array<double, 3>, std::pair<int, int>> places;  // first joined vertex, how many
  std::vector<int> joined_of(mesh.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& p = mesh.vertices[i];
    const Eigen::Vector2d uv = textured ? mesh.uvs[i] : Eigen::Vector2d::Zero().eval();
    const auto [it, added] =
        known.try_emplace({p.x(), p.y(), p.z(), uv.x(), uv.y()}, static_cast<int>(known.size()));
    joined_of[i] = it->second;
    if (!added) continue;
    out.original.push_back(static_cast<int>(i));
    out.vertices.push_back(p);
    const auto [place, first] = places.try_emplace({p.x(), p.y(), p.z()}, it->second, 0);
    out.locked.push_back(!first);
    if (!first) out.locked[place->second.first] = true;
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3i j(joined_of[t[0]], joined_of[t[1]], joined_of[t[2]]);
    if (j[0] != j[1] && j[1] != j[2] && j[2] != j[0]) out.triangles.push_back(j);
  }
  return out;
}

// Returns the area-weighted mean normal of those faces around a vertex that meet `face` without a
// crease.
Eigen::Vector3d CornerNormal(const std::vector<Eigen::Vector3d>& area_vectors,
                             const std::vector<int>& around, int face) {
  const Eigen::Vector3d own = area_vectors[face].normalized();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int other : around) {
    if (own.dot(area_vectors[other].normalized()) >= kCreaseCosine) sum += area_vectors[other];
  }
  return sum.norm() > 0 ? Eigen::Vector3d(sum.normalized()) : own;
}

// Returns the remaining triangles as a separate mesh with the attributes of `original`.
TriangleMesh Rebuild(const TriangleMesh& original, const Joined& joined,
                     const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<Eigen::Vector3d> area_vectors;
  std::vector<std::vector<int>> around(joined.vertices.size());
  for (const Eigen::Vector3i& t : triangles) {
    const Eigen::Vector3d& a = joined.vertices[t[0]];
    for (int k = 0; k < 3; ++k) around[t[k]].push_back(static_cast<int>(area_vectors.size()));
    area_vectors.push_back((joined.vertices[t[1]] - a).cross(joined.vertices[t[2]] - a));
  }
  TriangleMesh out;
  out.base_color = original.base_color;
  // Output vertices of each joined vertex; they differ in their normals.
  std::vector<std::vector<int>> copies(joined.vertices.size());
  for (size_t f = 0; f < triangles.size(); ++f) {
    Eigen::Vector3i corners;
    for (int k = 0; k < 3; ++k) {
      const int v = triangles[f][k];
      const Eigen::Vector3d normal = CornerNormal(area_vectors, around[v], static_cast<int>(f));
      int found = -1;
      for (const int copy : copies[v]) {
        if (original.normals.empty() || out.normals[copy].isApprox(normal, 1e-6)) found = copy;
      }
      if (found < 0) {
        found = static_cast<int>(out.vertices.size());
        copies[v].push_back(found);
        const int source = joined.original[v];
        out.vertices.push_back(joined.vertices[v]);
        if (!original.normals.empty()) out.normals.push_back(normal);
        if (!original.uvs.empty()) out.uvs.push_back(original.uvs[source]);
        if (!original.colors.empty()) out.colors.push_back(original.colors[source]);
      }
      corners[k] = found;
    }
    out.triangles.push_back(corners);
  }
  return out;
}

// Returns the vertices, edge midpoints, face centers and random points of a surface. Vertices of no
// triangle, which scans may have, are not on it.
std::vector<Eigen::Vector3d> Probes(const TriangleMesh& mesh) {
  Rng rng(0);
  std::vector<Eigen::Vector3d> probes = SampleSurface(mesh, kDeviationSamples, rng).points;
  std::vector<bool> is_used(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (const int vertex : t) is_used[vertex] = true;
  }
  for (size_t i = 0; i < is_used.size(); ++i) {
    if (is_used[i]) probes.push_back(mesh.vertices[i]);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
                          &c = mesh.vertices[t[2]];
    probes.insert(probes.end(), {(a + b) / 2, (b + c) / 2, (c + a) / 2, (a + b + c) / 3});
  }
  return probes;
}

// Returns the largest distance of the points from the surface, at least `farthest_m`. Most points
// are nearer than an earlier one; the cheaper test is then enough.
double Farthest_m(const MeshQuery& surface, const std::vector<Eigen::Vector3d>& points,
                  double farthest_m) {
  for (const Eigen::Vector3d& p : points) {
    if (surface.IsWithin(p, farthest_m)) continue;
    farthest_m = std::max(farthest_m, surface.ClosestPoint(p).distance);
  }
  return farthest_m;
}

// A surface prepared for measuring the distance to another surface in both directions.
struct Surface {
  explicit Surface(const TriangleMesh& mesh) : query(mesh), probes(Probes(mesh)) {}
  MeshQuery query;
  std::vector<Eigen::Vector3d> probes;
};

// Returns the largest distance between the two surfaces, at least `min_m`.
double Deviation_m(const Surface& a, const Surface& b, double min_m) {
  return Farthest_m(b.query, a.probes, Farthest_m(a.query, b.probes, min_m));
}

}  // namespace

std::vector<MeshLevel> MakeMeshLevels(const TriangleMesh& mesh) {
  std::vector<MeshLevel> levels{{mesh, 0.0}};
  if (mesh.triangles.size() < kMinTriangles) return levels;
  const double max_tolerance_m = kMaxToleranceShare * MeshBounds(mesh).size().norm();
  const Surface original(mesh);
  const Joined joined = Join(mesh);
  EdgeCollapse collapse(joined.vertices, joined.triangles, joined.locked);
  size_t last_count = mesh.triangles.size();
  for (double tolerance_m = kFirstTolerance_m; tolerance_m <= max_tolerance_m;
       tolerance_m *= std::numbers::sqrt2) {
    collapse.ReduceTo(tolerance_m);
    const std::vector<Eigen::Vector3i> triangles = collapse.Triangles();
    if (triangles.size() > (1 - kMinSaving) * last_count) continue;
    MeshLevel level{Rebuild(mesh, joined, triangles), 0.0};
    level.deviation_m = Deviation_m(original, Surface(level.mesh), levels.back().deviation_m);
    levels.push_back(std::move(level));
    last_count = triangles.size();
    if (last_count < kMinTriangles) break;
  }
  return levels;
}

TriangleMesh ReducedMesh(const TriangleMesh& mesh, double tolerance_m) {
  const Joined joined = Join(mesh);
  EdgeCollapse collapse(joined.vertices, joined.triangles, joined.locked, kLengthWeight);
  collapse.ReduceTo(tolerance_m);
  return Rebuild(mesh, joined, collapse.Triangles());
}

}  // namespace pickbed::scenes
