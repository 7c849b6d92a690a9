// Certified scenes judged by a test that shares no code with their certificate.

#include "tests/support/mesh_overlap.h"

#include <gtest/gtest.h>

#include "scenes/object_catalog.h"
#include "sim/convex_pieces.h"
#include "sim/scene_maker.h"

namespace pickbed {
namespace {

ObjectSet ConcaveParts() {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  ObjectSet objects;
  for (const char* name : {"bracket", "pipe_tee", "gear"}) objects.push_back(catalog.Load(name));
  return WithConvexPieces(objects);
}

TEST(MeshOverlap, CertifiedScenesHaveNone) {
  const ObjectSet objects = ConcaveParts();
  for (const uint64_t trial : {0, 1}) {
    const CertifiedScene made = MakeScene({Bin{}, objects, {6, 6, 6}, 3, trial});
    const MeshOverlap overlap = MeasureMeshOverlap(made.scene, objects);
    EXPECT_LT(overlap.deepest_m, 0.0005) << "trial " << trial;
    EXPECT_EQ(overlap.lost, 0) << "trial " << trial;
    EXPECT_EQ(made.scene.objects.size(), 18u) << "trial " << trial;
  }
}

// A second part of the same kind, 0.6 mm too near along the direction in which the first is flat.
TEST(MeshOverlap, APartPushedIntoAnotherIsFound) {
  const ObjectSet objects = ConcaveParts();
  for (size_t i = 0; i < objects.size(); ++i) {
    const Bounds bounds = MeshBounds(objects[i]->mesh_O);
    const auto scene_at = [&](double apart_m) {
      Scene scene;
      scene.bin.inner_size_m = {2, 2, 0};
      const Pose X_WO = Translation({0, 0, 0.5});
      const Pose turned = MakePose(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(),
                                   {0, 0, 0.5 + 2 * bounds.max.z() + apart_m});
      scene.objects = {{0, static_cast<int>(i), X_WO}, {1, static_cast<int>(i), turned}};
      return scene;
    };
    EXPECT_EQ(MeasureMeshOverlap(scene_at(1e-6), objects).deepest_m, 0) << objects[i]->name;
    EXPECT_NEAR(MeasureMeshOverlap(scene_at(-0.0006), objects).deepest_m, 0.0006, 2e-5)
        << objects[i]->name;
  }
}

TEST(MeshOverlap, APartInTheFloorInAWallOrOutsideIsFound) {
  const ObjectSet objects = ConcaveParts();
  const Bounds bounds = MeshBounds(objects[0]->mesh_O);
  const auto at = [&](const Eigen::Vector3d& p) {
    return MeasureMeshOverlap({Bin{}, {{0, 0, Translation(p)}}}, objects);
  };
  const double floor_z = -bounds.min.z(), wall_x = 0.2 - bounds.max.x();
  EXPECT_LT(at({0, 0, floor_z}).deepest_m, 1e-9);
  EXPECT_NEAR(at({0, 0, floor_z - 0.0006}).deepest_m, 0.0006, 1e-9);
  EXPECT_NEAR(at({wall_x + 0.0006, 0, floor_z + 0.01}).deepest_m, 0.0006, 1e-9);
  EXPECT_EQ(at({0.5, 0, floor_z}).lost, 1);
  EXPECT_EQ(at({0, 0, floor_z}).lost, 0);
}

}  // namespace
}  // namespace pickbed
