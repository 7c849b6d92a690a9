#include <gtest/gtest.h>

#include <algorithm>

#include "perception/verify/physical_consistency.h"
#include "scenes/base/random.h"
#include "scenes/geometry/mesh_query.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// Two cubes of 40 mm, side by side along x. They overlap by 40 mm minus their distance.
class Cubes : public ::testing::Test {
 protected:
  Cubes()
      : models_{MakeModelPoints(*ObjectOf(BoxMesh({0.04, 0.04, 0.04}, Eigen::Vector3d::Zero())))} {}

  double Depth(double distance_m, const Eigen::Vector3d& axis = {0, 0, 1}, double deg = 0) const {
    return PenetrationDepth(models_[0], Pose::Identity(), models_[0],
                            Perturbed(Translation({distance_m, 0, 0}), axis, deg, {0, 0, 0}));
  }

  std::vector<ModelPoints> models_;
};

TEST_F(Cubes, DepthEqualsTheOverlap) {
  const double cell_m = models_[0].distance.cell_m;
  for (const double shared_m : {0.004, 0.008, 0.012}) {
    EXPECT_NEAR(Depth(0.04 - shared_m), shared_m, cell_m) << shared_m;
  }
  EXPECT_EQ(Depth(0.041), 0);
  EXPECT_EQ(Depth(0.2), 0);
  // The second cube with an edge first: half of its diagonal is 28.3 mm.
  EXPECT_NEAR(Depth(0.02 + 0.0283 - 0.006, {0, 0, 1}, 45), 0.006, cell_m);
}

bool IsInside(const MeshQuery& query, const Eigen::Vector3d& p) {
  const auto hits = query.AllHits(p, Eigen::Vector3d(0.3, 0.5, 0.81).normalized());
  return std::count_if(hits.begin(), hits.end(), [](const auto& h) { return h.distance > 0; }) % 2;
}

TEST(PenetrationDepth, ObjectInAHollowDoesNotPenetrate) {
  const std::vector<ModelPoints> models{
      MakeModelPoints(*ObjectOf(BracketMesh())),
      MakeModelPoints(*ObjectOf(BoxMesh({0.008, 0.008, 0.008}, Eigen::Vector3d::Zero())))};
  const MeshQuery query(BracketMesh());
  Rng rng(4);
  int apart = 0, within = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-0.03, 0.03), rng.Uniform(-0.02, 0.02),
                            rng.Uniform(-0.03, 0.03));
    const double gap_m = query.ClosestPoint(p).distance;
    const double depth_m = PenetrationDepth(models[1], Translation(p), models[0], Pose::Identity());
    if (!IsInside(query, p) && gap_m > 0.0075) {  // more than half of the box's diagonal
      EXPECT_LT(depth_m, 0.001);
      ++apart;
    } else if (IsInside(query, p) && gap_m > models[0].distance.cell_m) {
      EXPECT_GT(depth_m, 0.001);
      ++within;
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_GT(within, 100);
}

}  // namespace
}  // namespace pickbed::tests
