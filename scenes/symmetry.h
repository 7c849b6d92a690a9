#pragma once

// Symmetries of an object as BOP's models_info states them: discrete transforms and continuous
// axes. A symmetry S maps the object onto itself: X_WO and X_WO * S look the same.

#include <Eigen/Core>
#include <vector>

#include "scenes/pose.h"

namespace pickbed {

struct ContinuousSymmetry {
  Eigen::Vector3d axis_O = Eigen::Vector3d::UnitZ();   // unit
  Eigen::Vector3d offset_O = Eigen::Vector3d::Zero();  // a point on the axis, m
};

// The turn about the axis by an angle; axis_O must be unit.
Pose TurnAbout(const ContinuousSymmetry& axis, double angle_rad);

// The point of a rotation's axis that is nearest to the origin.
Eigen::Vector3d PointOnAxis(const Pose& X);

struct SymmetrySet {
  std::vector<Pose> discrete_O;  // without the identity
  std::vector<ContinuousSymmetry> continuous_O;
  bool trivial() const { return discrete_O.empty() && continuous_O.empty(); }
};

// The first continuous axis of another direction than the first one's, with which the part is a
// ball; null = none.
const ContinuousSymmetry* SecondAxis(const SymmetrySet& symmetries);

// All symmetry transforms, identity first, continuous axes in `steps` equal turns (the BOP toolkit
// chooses the step so that the surface moves at most 1 % of the diameter: pi / 0.01 steps).
// Discrete ones are composed with the continuous ones. Two axes that cross make a ball: all
// rotations about the crossing, on a grid of about 32 * steps. Throws InputError for two axes that
// don't meet.
std::vector<Pose> SymmetryTransforms(const SymmetrySet& symmetries, int steps = 314);

}  // namespace pickbed
