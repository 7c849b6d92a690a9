#pragma once

// Volume, center of mass and inertia of the solid inside a closed mesh of uniform density. They are
// computed with the divergence theorem over tetrahedra, as in Mirtich 1996.

#include <Eigen/Core>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Mass properties of a solid in its object frame O.
struct MassProperties {
  double mass_kg = 0;
  double volume_m3 = 0;
  Eigen::Vector3d com_O = Eigen::Vector3d::Zero();          // m
  Eigen::Matrix3d inertia_com_O = Eigen::Matrix3d::Zero();  // kg m^2, about com, axes of O
};

// A mesh is flat if its volume divided by the cubed diagonal of its bounding box is below this
// value. Such a volume is only rounding noise. A foil of 0.1 micrometre over 100 mm still passes.
inline constexpr double kFlatVolumeRatio = 1e-9;

// Returns the mass properties for a given mass. Throws InputError when the mass is not positive or
// the mesh encloses no positive volume (see kFlatVolumeRatio).
MassProperties UniformMassProperties(const TriangleMesh& closed_mesh, double mass_kg);

// Returns the mass properties for a given density. Throws InputError when the density is not
// positive or the mesh encloses no positive volume.
MassProperties UniformDensityProperties(const TriangleMesh& closed_mesh, double density_kgpm3);

}  // namespace pickbed::scenes
