#pragma once

// Objects made of boxes for physics tests, with mass properties by the parallel-axis theorem.

#include <memory>
#include <string>
#include <vector>

#include "scenes/bin/bin.h"
#include "scenes/objects/object_model.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

inline ConvexPiece BoxPiece(const AxisAlignedBox& box) {
  ConvexPiece piece;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    piece.vertices_O.push_back(box.center + sign.cwiseProduct(box.half_size));
  }
  return piece;
}

// Returns the closed surface of one box.
inline TriangleMesh BoxMesh(const AxisAlignedBox& box) {
  TriangleMesh mesh;
  mesh.vertices = BoxPiece(box).vertices_O;
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

inline MassProperties MassOfBoxes(const std::vector<AxisAlignedBox>& boxes, double mass_kg) {
  MassProperties mass;
  mass.mass_kg = mass_kg;
  for (const AxisAlignedBox& box : boxes) {
    const double volume_m3 = 8 * box.half_size.prod();
    mass.volume_m3 += volume_m3;
    mass.com_O += volume_m3 * box.center;
  }
  mass.com_O /= mass.volume_m3;
  for (const AxisAlignedBox& box : boxes) {
    const double m = mass_kg * 8 * box.half_size.prod() / mass.volume_m3;
    const Eigen::Vector3d square = box.half_size.cwiseAbs2();
    const Eigen::Vector3d r = box.center - mass.com_O;
    mass.inertia_com_O += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    mass.inertia_com_O += (m / 3 * (square.sum() * Eigen::Vector3d::Ones() - square)).asDiagonal();
  }
  return mass;
}

inline std::shared_ptr<const ObjectModel> ObjectOfBoxes(const std::string& name,
                                                        const std::vector<AxisAlignedBox>& boxes,
                                                        double mass_kg, double friction = 0.5) {
  auto model = std::make_shared<ObjectModel>();
  model->name = name;
  model->friction = friction;
  model->mass = MassOfBoxes(boxes, mass_kg);
  for (const AxisAlignedBox& box : boxes) {
    model->convex_pieces_O.push_back(BoxPiece(box));
    Append(BoxMesh(box), model->mesh_O);
  }
  model->diameter_m = Diameter(model->mesh_O);
  model->mesh_hash = MeshHash(model->mesh_O);
  return model;
}

inline std::shared_ptr<const ObjectModel> BoxObject(const Eigen::Vector3d& size_m, double mass_kg,
                                                    double friction = 0.5) {
  return ObjectOfBoxes("box", {{Eigen::Vector3d::Zero(), 0.5 * size_m}}, mass_kg, friction);
}

// An L of two plates, 80 x 40 x 50 mm, 6 mm thick.
inline std::shared_ptr<const ObjectModel> BracketObject() {
  return ObjectOfBoxes(
      "bracket",
      {{{0, 0, 0.003}, {0.040, 0.020, 0.003}}, {{-0.037, 0, 0.028}, {0.003, 0.020, 0.022}}}, 0.08);
}

// A T of two bars, 90 x 60 x 20 mm.
inline std::shared_ptr<const ObjectModel> TeeObject() {
  return ObjectOfBoxes(
      "tee", {{{0, 0, 0}, {0.045, 0.010, 0.010}}, {{0, 0.035, 0}, {0.010, 0.025, 0.010}}}, 0.12);
}

// Brackets, tees, long blocks and small cubes.
inline ObjectSet MixedObjects() {
  return {BracketObject(), TeeObject(), BoxObject({0.10, 0.03, 0.02}, 0.15),
          BoxObject({0.025, 0.025, 0.025}, 0.04)};
}

}  // namespace pickbed::tests
