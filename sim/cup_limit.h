#pragma once

// What a sealed lip bears: one model, for the joint that breaks and for the planner.
//
// The lip is a ring of contact (Mahler et al. 2018, "Dex-Net 3.0", section IV). The air presses it
// on with vacuum_n; pull takes from that force, and what the part presses on adds to it, up to as
// much again. The ring bears bending until all of the force stands on one point of it, and shear
// and torsion by friction, together within an ellipsoid. Its radius is where the cup tips off under
// moment_limit_nm without a pull, and not beyond the lip.

#include <Eigen/Core>

#include "sim/cup_joint.h"

namespace pickbed {

// Of the part on the cup, in G, about the lip's middle.
struct LipLoad {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_nm = Eigen::Vector3d::Zero();
};

double RingRadius_m(const CupSpec& spec);

// From 1 on the lip comes off. `pair_friction` as by scenes/friction.h.
double ShareOfLimit(const CupSpec& spec, double pair_friction, const LipLoad& load);

}  // namespace pickbed
