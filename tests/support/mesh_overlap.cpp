#include "tests/support/mesh_overlap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "scenes/geometry/mesh_query.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing_m = 0.001;
constexpr double kSharp = 0.9;  // maximum cosine between the face normals of a sharp edge

std::vector<Vector3d> ProbesOf(const TriangleMesh& mesh, int samples) {
  Rng rng(1);
  std::vector<Vector3d> probes = SampleSurface(mesh, samples, rng).points;
  probes.insert(probes.end(), mesh.vertices.begin(), mesh.vertices.end());
  const std::vector<Vector3d> normals = FaceNormals(mesh);
  std::map<std::pair<int, int>, int> first_face;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
      const auto [entry, is_new] = first_face.try_emplace(std::minmax(a, b), static_cast<int>(i));
      if (is_new || normals[entry->second].dot(normals[i]) > kSharp) continue;
      const Vector3d along = mesh.vertices[b] - mesh.vertices[a];
      const int steps = static_cast<int>(along.norm() / kSpacing_m);
      for (int s = 1; s <= steps; ++s) {
        probes.push_back(mesh.vertices[a] + along * (s / (steps + 1.0)));
      }
    }
  }
  return probes;
}

bool IsInside(const MeshQuery& mesh, const Vector3d& p) {
  for (const Vector3d& direction : {Vector3d(0.267, 0.535, 0.802), Vector3d(-0.81, 0.31, -0.5)}) {
    int ahead = 0;
    for (const SurfaceHit& hit : mesh.AllHits(p, direction.normalized())) {
      ahead += hit.distance > 0;
    }
    if (ahead % 2 == 0) return false;
  }
  return true;
}

// Returns the depth of a point below the floor, or inside a wall below its rim, in metres.
double DepthInBin(const Bin& bin, const Vector3d& p_W) {
  const Vector3d half = 0.5 * bin.inner_size_m;
  double depth_m = std::max(0.0, -p_W.z());
  if (p_W.z() <= 0 || p_W.z() >= bin.inner_size_m.z()) return depth_m;
  const Eigen::Vector2d beyond = p_W.head<2>().cwiseAbs() - half.head<2>();
  return std::max(depth_m, std::min(beyond.maxCoeff(), bin.inner_size_m.z() - p_W.z()));
}

}  // namespace

MeshOverlap MeasureMeshOverlap(const Scene& scene, const ObjectSet& objects, int samples) {
  std::vector<MeshQuery> meshes;
  std::vector<Bounds> bounds;
  std::vector<std::vector<Vector3d>> probes_O;
  for (const auto& object : objects) {
    meshes.emplace_back(object->mesh_O);
    bounds.push_back(MeshBounds(object->mesh_O));
    probes_O.push_back(ProbesOf(object->mesh_O, samples));
  }
  MeshOverlap overlap;
  const Eigen::Vector2d half = 0.5 * scene.bin.inner_size_m.head<2>();
  for (const PosedObject& a : scene.objects) {
    const Vector3d center_W = a.X_WO * bounds[a.object].center();
    const bool is_in = (center_W.head<2>().cwiseAbs().array() <= half.array()).all() &&
                       center_W.z() > 0 && a.X_WO.matrix().allFinite();
    overlap.lost += !is_in;
    for (const Vector3d& p_O : probes_O[a.object]) {
      overlap.deepest_m = std::max(overlap.deepest_m, DepthInBin(scene.bin, a.X_WO * p_O));
    }
    for (const PosedObject& b : scene.objects) {
      const Pose X_BA = b.X_WO.inverse() * a.X_WO;
      const double reach = 0.5 * (objects[a.object]->diameter_m + objects[b.object]->diameter_m);
      const Bounds& box = bounds[b.object];
      if (&a == &b || (X_BA * bounds[a.object].center() - box.center()).norm() > 1.5 * reach) {
        continue;
      }
      for (const Vector3d& p_A : probes_O[a.object]) {
        const Vector3d p = X_BA * p_A;
        const double depth_bound_m = (p - box.min).cwiseMin(box.max - p).minCoeff();
        if (depth_bound_m <= overlap.deepest_m || !IsInside(meshes[b.object], p)) continue;
        overlap.deepest_m = std::max(overlap.deepest_m, meshes[b.object].ClosestPoint(p).distance);
      }
    }
  }
  return overlap;
}

}  // namespace pickbed::tests
