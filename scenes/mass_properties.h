#pragma once

// Volume, centre of mass and inertia of the solid inside a closed mesh of uniform density
// (divergence theorem over tetrahedra, as in Mirtich 1996).

#include <Eigen/Core>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct MassProperties {
  double mass_kg = 0;
  double volume_m3 = 0;
  Eigen::Vector3d com_O = Eigen::Vector3d::Zero();          // m
  Eigen::Matrix3d inertia_com_O = Eigen::Matrix3d::Zero();  // kg m^2, about com, axes of O
};

// Throws InputError when the enclosed volume is not positive.
MassProperties UniformMassProperties(const TriangleMesh& closed_mesh, double mass_kg);

}  // namespace pickbed
