#include "grasp/completed/completed_object.h"

#include <algorithm>
#include <vector>

#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// Returns the largest closed piece of a mesh.
TriangleMesh LargestPiece(const TriangleMesh& mesh) {
  const int count = static_cast<int>(mesh.vertices.size());
  std::vector<int> parent(count);
  for (int i = 0; i < count; ++i) parent[i] = i;
  const auto root_of = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (const int k : {1, 2}) parent[root_of(t[k])] = root_of(t[0]);
  }
  std::vector<int> triangles(count, 0);
  for (const Eigen::Vector3i& t : mesh.triangles) ++triangles[root_of(t[0])];
  const auto largest = std::max_element(triangles.begin(), triangles.end()) - triangles.begin();
  TriangleMesh piece;
  std::vector<int> number(count, -1);
  for (int i = 0; i < count; ++i) {
    if (root_of(i) != largest) continue;
    number[i] = static_cast<int>(piece.vertices.size());
    piece.vertices.push_back(mesh.vertices[i]);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (number[t[0]] >= 0) piece.triangles.emplace_back(number[t[0]], number[t[1]], number[t[2]]);
  }
  return piece;
}

// Returns the model of an object, or null if its surface encloses no volume.
std::shared_ptr<const ObjectModel> ModelOf(const TriangleMesh& mesh_O,
                                           const CompletedObjectOptions& options) {
  auto model = std::make_shared<ObjectModel>();
  model->name = "completed";
  model->mesh_O = mesh_O;
  try {
    model->mass = UniformDensityProperties(mesh_O, options.density_kgpm3);
  } catch (const InputError&) {
    return nullptr;
  }
  model->friction = options.friction;
  model->resting_O = {{Vector3d::UnitZ(), 1}};
  model->diameter_m = MeshBounds(mesh_O).size().norm();
  return model;
}

}  // namespace

std::optional<CompletedObject> MakeCompletedObject(const OccupancyShape& shape, const Pose& X_BW,
                                                   const CompletedObjectOptions& options) {
  TriangleMesh mesh_B = Transformed(SurfaceOf(shape, options.surface_level), X_BW * shape.X_WV);
  if (mesh_B.triangles.empty()) return std::nullopt;
  mesh_B = LargestPiece(mesh_B);
  const Pose X_BO = Translation(MeshBounds(mesh_B).center());
  const auto model = ModelOf(Transformed(mesh_B, X_BO.inverse()), options);
  if (model == nullptr) return std::nullopt;
  return CompletedObject{model, X_BO};
}

}  // namespace pickbed::grasp
