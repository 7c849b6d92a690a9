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

// A mesh whose volume is below this share of its bounding box's diagonal cubed is flat: what is
// left is rounding noise (a foil of 0.1 micrometre over 100 mm still passes).
inline constexpr double kFlatVolumeRatio = 1e-9;

// Throws InputError when the enclosed volume or the mass is not positive.
MassProperties UniformMassProperties(const TriangleMesh& closed_mesh, double mass_kg);

// The same from a density. Throws InputError when the enclosed volume or density is not positive.
MassProperties UniformDensityProperties(const TriangleMesh& closed_mesh, double density_kgpm3);

}  // namespace pickbed
