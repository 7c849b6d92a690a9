#pragma once

// Shape of an object as the planner on poses needs it.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "grasp/plan/clearance.h"
#include "grasp/plan/plan.h"

namespace pickbed::grasp {

// Data shared by all poses of one object.
struct ObjectShape {
  Eigen::Matrix3Xd points_O;    // uniform density
  Eigen::Matrix3Xd obstacle_O;  // points_O and points along sharp edges
  double thickness_m;           // minimum extent along the axes of O
  double band_radius_m;         // around O; the band has no point further away
  SurfaceBand band;
  std::vector<std::optional<double>> openings_m;  // by candidate; nullopt = beyond the stroke
};

// Returns the shape of an object of `input`, in the density that `options` give.
ObjectShape MakeShape(const PlanInput& input, ObjectId object, const PlanOptions& options);

}  // namespace pickbed::grasp
