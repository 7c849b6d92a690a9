#pragma once

// A minimal scenario for tests: cubes and the oracle estimator, no catalog files, no network.

#include <memory>

#include "scenes/geometry/mass_properties.h"
#include "scenes/objects/object_model.h"
#include "scenes/scenario/scenario_spec.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

inline std::shared_ptr<const ObjectModel> Cube(double side_m, double mass_kg, double friction) {
  auto model = std::make_shared<ObjectModel>();
  model->name = "cube";
  for (int corner = 0; corner < 8; ++corner) {
    model->mesh_O.vertices.push_back(side_m * Eigen::Vector3d(corner & 1 ? 0.5 : -0.5,
                                                              corner & 2 ? 0.5 : -0.5,
                                                              corner & 4 ? 0.5 : -0.5));
  }
  model->mesh_O.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                             {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  model->mass = UniformMassProperties(model->mesh_O, mass_kg);
  model->friction = friction;
  model->convex_pieces_O = {{model->mesh_O.vertices}};
  model->diameter_m = Diameter(model->mesh_O);
  model->mesh_hash = static_cast<uint64_t>(1e6 * side_m);
  return model;
}

inline ScenarioSpec CubeScenario(int count) {
  ScenarioSpec spec;
  spec.seed = 11;
  ObjectSpec object;
  object.name = "cube";
  object.count = count;
  spec.objects = {object};
  spec.estimator.name = "oracle";
  return spec;
}

inline ObjectSet EasyCube() { return {Cube(0.03, 0.05, 0.6)}; }

}  // namespace pickbed::tests
