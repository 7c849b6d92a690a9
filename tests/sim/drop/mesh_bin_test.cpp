// Scenes in a bin with a mesh.

#include <gtest/gtest.h>

#include "sim/drop/drop.h"
#include "sim/drop/penetration.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/tapered_bin.h"

namespace pickbed::tests {
namespace {

Bin BinFrom(const TriangleMesh& mesh) {
  Bin bin;
  bin.shape = std::make_shared<const BinShape>(MakeBinShape(mesh, "test bin"));
  bin.inner_size_m = bin.shape->inner_size_m;
  bin.wall_m = bin.shape->wall_m;
  return bin;
}

Bin SheetMetal() {
  Bin bin;
  bin.wall_m = 0.001;
  return bin;
}

// A bin with the mesh of a box behaves like the box bin, down to 1 mm of sheet metal.
TEST(MeshBin, ScenesAreAsValidAsInABox) {
  for (const TriangleMesh& mesh : {BinMesh(Bin{}), BinMesh(SheetMetal()), TaperedBin()}) {
    const Bin bin = BinFrom(mesh);
    for (const uint64_t seed : {0, 1, 2}) {
      Rng rng(seed);
      const DropResult drop = DropInstances(bin, MixedObjects(), {5, 5, 5, 5}, rng);
      EXPECT_TRUE(Faults(drop.certificate).empty()) << "seed " << seed;
      EXPECT_EQ(drop.scene.objects.size(), 20u) << "seed " << seed;
      EXPECT_LT(drop.certificate.deepest_penetration_m, 0.0005) << "seed " << seed;
    }
  }
}

TEST(MeshBin, RestingHeightIsOnTheFloor) {
  const Bin bin = BinFrom(TaperedBin());
  PhysicsWorld world;
  world.AddBin(bin);
  const auto cube = BoxObject(Eigen::Vector3d::Constant(0.04), 0.05);
  world.AddInstance(*cube, Translation({0, 0, 0.03}));
  while (world.time_s() < 1) world.Step();
  EXPECT_NEAR(world.X_WO(0).translation().z(), 0.0205, 1e-4);
}

// A cube with low friction slides down the sloped wall. A box bin of the same inner size would stop
// it.
TEST(MeshBin, CubeSlidesDownTheSlopedWall) {
  const Bin bin = BinFrom(TaperedBin());
  PhysicsWorld world;
  world.AddBin(bin);
  const auto cube = BoxObject(Eigen::Vector3d::Constant(0.02), 0.05, 0.05);
  world.AddInstance(*cube, Translation({0.175, 0, 0.11}));
  while (world.time_s() < 1) world.Step();
  EXPECT_LT(world.X_WO(0).translation().z(), 0.03);
  EXPECT_LT(std::abs(world.X_WO(0).translation().x()), 0.16);
}

TEST(MeshBin, OverlapWithFloorAndWallIsMeasured) {
  const auto cube = BoxObject(Eigen::Vector3d::Constant(0.04), 0.05);
  const auto depth = [&](const Eigen::Vector3d& p) {
    const Scene scene{BinFrom(TaperedBin()), {{InstanceId{0}, ObjectId{0}, Translation(p)}}};
    return DeepestPenetration(scene, {cube});
  };
  EXPECT_EQ(depth({0, 0, 0.0201}), 0);
  EXPECT_NEAR(depth({0, 0, 0.0194}), 0.0006, 1e-9);
  EXPECT_NEAR(depth({0, 0, 0.01}), 0.01, 1e-9);  // more than the thickness of the floor
  // The wall at +x leans outwards by 0.05 m over a height of 0.12 m: x = 0.15 + 5 / 12 z.
  const double slope = 5.0 / 12, touching_x = 0.15 + slope * 0.03 - 0.02;
  EXPECT_EQ(depth({touching_x - 0.0001, 0, 0.05}), 0);
  EXPECT_NEAR(depth({touching_x + 0.0010, 0, 0.05}), 0.0010 / std::hypot(1, slope), 1e-6);
}

}  // namespace
}  // namespace pickbed::tests
