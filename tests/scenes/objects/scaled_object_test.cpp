#include "scenes/objects/scaled_object.h"

#include <gtest/gtest.h>

#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// A box whose center of mass is not at the origin of O.
TEST(ScaledObject, HasTheMassPropertiesOfALargerSolidOfTheSameDensity) {
  constexpr double kFactor = 1.25;
  const AxisAlignedBox box{{0.03, 0.01, 0.005}, {0.02, 0.01, 0.005}};
  ObjectModel model;
  model.mesh_O = BoxMesh(box);
  model.convex_pieces_O = {BoxPiece(box)};
  model.mass = UniformMassProperties(model.mesh_O, 0.2);
  model.diameter_m = Diameter(model.mesh_O);
  model.symmetries_O.continuous_O = {{Eigen::Vector3d::UnitX(), {0, 0.01, 0.005}}};
  model.symmetries_O.discrete_O = {Translation({0.06, 0, 0})};
  const double density_kgpm3 = model.mass.mass_kg / model.mass.volume_m3;

  const ObjectModel large = ScaledObject(model, kFactor);
  const MassProperties expected = UniformDensityProperties(large.mesh_O, density_kgpm3);
  EXPECT_NEAR(large.mass.mass_kg, expected.mass_kg, 1e-12);
  EXPECT_NEAR(large.mass.volume_m3, expected.volume_m3, 1e-15);
  EXPECT_TRUE(large.mass.com_O.isApprox(expected.com_O, 1e-9));
  EXPECT_TRUE(large.mass.inertia_com_O.isApprox(expected.inertia_com_O, 1e-9));
  EXPECT_NEAR(large.diameter_m, Diameter(large.mesh_O), 1e-12);
  EXPECT_TRUE(large.convex_pieces_O[0].vertices_O[7].isApprox(large.mesh_O.vertices[7], 1e-12));
  EXPECT_TRUE(large.symmetries_O.continuous_O[0].offset_O.isApprox(
      kFactor * model.symmetries_O.continuous_O[0].offset_O));
  EXPECT_NEAR(large.symmetries_O.discrete_O[0].translation().x(), kFactor * 0.06, 1e-12);
  EXPECT_NE(large.mesh_hash, MeshHash(model.mesh_O)) << "no cache may mistake it for the model";
}

}  // namespace
}  // namespace pickbed::tests
