#pragma once

// Symmetries of an object in the form of BOP's models_info: discrete transforms and continuous
// axes. A symmetry S maps the object onto itself, so X_WO and X_WO * S look the same.

#include <Eigen/Core>
#include <vector>

#include "scenes/geometry/pose.h"

namespace pickbed::scenes {

// An axis about which every rotation is a symmetry.
struct ContinuousSymmetry {
  Eigen::Vector3d axis_O = Eigen::Vector3d::UnitZ();   // unit
  Eigen::Vector3d offset_O = Eigen::Vector3d::Zero();  // a point on the axis, m
};

// Returns the rotation about the axis by an angle; axis_O must be a unit vector.
Pose TurnAbout(const ContinuousSymmetry& axis, double angle_rad);

// Returns the point of the axis of rotation of `X` that is nearest to the origin, in m.
Eigen::Vector3d PointOnAxis(const Pose& X);

// The symmetries of one object.
struct SymmetrySet {
  std::vector<Pose> discrete_O;  // without the identity
  std::vector<ContinuousSymmetry> continuous_O;
  bool trivial() const { return discrete_O.empty() && continuous_O.empty(); }
};

// Returns the first continuous axis that is not parallel to the first one. An object with two such
// axes is a ball. Returns null if there is none.
const ContinuousSymmetry* SecondAxis(const SymmetrySet& symmetries);

// Returns all symmetry transforms, with the identity first. A continuous axis gives `steps` equal
// rotations. The default follows the BOP toolkit: the surface moves at most 1 % of the diameter per
// step, which needs pi / 0.01 steps, rounded up. Discrete transforms are composed with the
// continuous ones. Two axes that cross (a ball) give rotations about the crossing on a grid of
// about 32 * steps. Throws InputError for two axes that do not meet and std::invalid_argument for
// steps < 1.
std::vector<Pose> SymmetryTransforms(const SymmetrySet& symmetries, int steps = 315);

}  // namespace pickbed::scenes
