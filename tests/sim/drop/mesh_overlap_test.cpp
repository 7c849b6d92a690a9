// Checks certified scenes with a test that shares no code with the certificate.

#include "tests/support/mesh_overlap.h"

#include <gtest/gtest.h>

#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"

namespace pickbed::tests {
namespace {

ObjectSet ConcaveObjects() {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  ObjectSet objects;
  for (const char* name : {"bracket", "pipe_tee", "gear"}) objects.push_back(catalog.Load(name));
  return WithConvexPieces(objects);
}

TEST(MeshOverlap, CertifiedScenesHaveNoOverlap) {
  const ObjectSet objects = ConcaveObjects();
  for (const int trial : {0, 1}) {
    const CertifiedScene made = MakeScene({Bin{}, objects, {6, 6, 6}, 3, BinIndex(trial)});
    const MeshOverlap overlap = MeasureMeshOverlap(made.scene, objects);
    EXPECT_LT(overlap.deepest_m, 0.0005) << "trial " << trial;
    EXPECT_EQ(overlap.lost, 0) << "trial " << trial;
    EXPECT_EQ(made.scene.objects.size(), 18u) << "trial " << trial;
  }
}

// A second instance of the same object overlaps the first by 0.6 mm, along the direction in which
// the object is flat.
TEST(MeshOverlap, OverlapOfTwoInstancesIsMeasured) {
  const ObjectSet objects = ConcaveObjects();
  for (size_t i = 0; i < objects.size(); ++i) {
    const Bounds bounds = MeshBounds(objects[i]->mesh_O);
    const auto scene_at = [&](double gap_m) {
      Scene scene;
      scene.bin.inner_size_m = {2, 2, 0};
      const Pose X_WO = Translation({0, 0, 0.5});
      const Pose flipped = MakePose(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(),
                                    {0, 0, 0.5 + 2 * bounds.max.z() + gap_m});
      scene.objects = {{InstanceId{0}, ObjectId(i), X_WO}, {InstanceId{1}, ObjectId(i), flipped}};
      return scene;
    };
    EXPECT_EQ(MeasureMeshOverlap(scene_at(1e-6), objects).deepest_m, 0) << objects[i]->name;
    EXPECT_NEAR(MeasureMeshOverlap(scene_at(-0.0006), objects).deepest_m, 0.0006, 2e-5)
        << objects[i]->name;
  }
}

TEST(MeshOverlap, InstanceInFloorOrWallOrOutsideIsFound) {
  const ObjectSet objects = ConcaveObjects();
  const Bounds bounds = MeshBounds(objects[0]->mesh_O);
  const auto at = [&](const Eigen::Vector3d& p) {
    return MeasureMeshOverlap({Bin{}, {{InstanceId{0}, ObjectId{0}, Translation(p)}}}, objects);
  };
  const double floor_z = -bounds.min.z(), wall_x = 0.2 - bounds.max.x();
  EXPECT_LT(at({0, 0, floor_z}).deepest_m, 1e-9);
  EXPECT_NEAR(at({0, 0, floor_z - 0.0006}).deepest_m, 0.0006, 1e-9);
  EXPECT_NEAR(at({wall_x + 0.0006, 0, floor_z + 0.01}).deepest_m, 0.0006, 1e-9);
  EXPECT_EQ(at({0.5, 0, floor_z}).lost, 1);
  EXPECT_EQ(at({0, 0, floor_z}).lost, 0);
}

}  // namespace
}  // namespace pickbed::tests
