#pragma once

// Object that a planner makes from a completed shape.

#include <memory>
#include <optional>

#include "grasp/completed/occupancy_shape.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

// What a planner assumes about an unknown object.
struct CompletedObjectOptions {
  double surface_level = kSurfaceLevel;  // probability at the surface
  double density_kgpm3 = 1500;
  double friction = 0.5;  // ObjectModel::friction
};

// Frame O has the axes of the bin's frame B and its origin at the center of the surface.
struct CompletedObject {
  std::shared_ptr<const ObjectModel> model;  // without convex pieces
  Pose X_BO = Pose::Identity();
};

// Returns the object of a shape, or nullopt if its surface encloses no volume. The largest closed
// piece is taken, since an object has one and small ones are noise. `X_BW` is the pose of the world
// in B.
std::optional<CompletedObject> MakeCompletedObject(const OccupancyShape& shape, const Pose& X_BW,
                                                   const CompletedObjectOptions& options);

}  // namespace pickbed::grasp
