#include <gtest/gtest.h>

#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/drop.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

std::shared_ptr<const ObjectModel> WithDiameter(const ObjectModel& model, double diameter_m) {
  const double s = diameter_m / model.diameter_m;
  auto scaled = std::make_shared<ObjectModel>(model);
  scaled->mesh_O = Scaled(model.mesh_O, s);
  scaled->diameter_m = diameter_m;
  scaled->mass.mass_kg *= s * s * s;
  scaled->mass.com_O *= s;
  scaled->mass.inertia_com_O *= s * s * s * s * s;
  for (ConvexPiece& piece : scaled->convex_pieces_O) {
    for (Eigen::Vector3d& p : piece.vertices_O) p *= s;
  }
  return scaled;
}

// The overlap stays below 1 % of the diameter for any size. (With the step of large objects,
// objects of 1 cm overlap by 5 %.)
TEST(DropInstances, SmallObjectsOverlapAsLittleAsLargeObjects) {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  for (const double diameter_m : {0.1, 0.01}) {
    ObjectSet objects;
    for (const char* name : {"bracket", "pipe_tee", "gear"}) {
      objects.push_back(WithDiameter(*WithConvexPieces(catalog.Load(name)), diameter_m));
    }
    Bin bin;
    bin.inner_size_m *= diameter_m / 0.1;
    for (const uint64_t seed : {0, 1}) {
      Rng rng(seed);
      const DropResult drop = DropInstances(bin, objects, {10, 10, 10}, rng);
      EXPECT_TRUE(drop.certificate.at_rest) << diameter_m << " m, seed " << seed;
      EXPECT_EQ(drop.certificate.instances_outside, 0) << diameter_m << " m, seed " << seed;
      EXPECT_LT(drop.certificate.deepest_penetration_m, 0.01 * diameter_m) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
