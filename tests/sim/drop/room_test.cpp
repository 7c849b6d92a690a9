#include "sim/drop/room.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/sensor/sensor_failures.h"

namespace pickbed::tests {
namespace {

class Room : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto object = std::make_shared<ObjectModel>();
    object->diameter_m = 0.09;
    shapes_ = new RoomShapes(MakeRoomShapes({object}, kCell_m));
  }
  static void TearDownTestSuite() { delete shapes_; }

  static constexpr double kCell_m = 0.5;
  static RoomShapes* shapes_;
};
RoomShapes* Room::shapes_ = nullptr;

// Nothing enters the balls that are kept free or encloses the camera, and things rest on the
// surface below the cell.
TEST_F(Room, ThingsRestOutsideTheBin) {
  const std::vector<const TriangleMesh*> meshes = shapes_->All();
  const size_t planks = 1 + shapes_->table_tops.size();
  int things = 0;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    RoomCell cell;
    cell.cell_m = kCell_m;
    cell.support_m = -0.006;
    cell.eye_B = {0.3, 0, 0.8};
    cell.kept_free = {{{0, 0, 0}, 0.25}};
    Rng rng(seed);
    for (const PlacedShape& placed : PlaceRoom(*shapes_, cell, rng)) {
      if (static_cast<size_t>(placed.shape) < planks) continue;
      ++things;
      double lowest_m = 1;
      for (const Eigen::Vector3d& p : meshes[placed.shape]->vertices) {
        const Eigen::Vector3d p_B = placed.X_BS * p;
        lowest_m = std::min(lowest_m, p_B.z());
        EXPECT_GT(p_B.norm(), 0.25);
        EXPECT_GT((p_B - cell.eye_B).norm(), 0.1 * kCell_m);
      }
      EXPECT_NEAR(lowest_m, cell.support_m, 1e-9);
    }
  }
  EXPECT_GT(things, 100);
}

TEST_F(Room, SameSeedSameRoom) {
  RoomCell cell;
  cell.eye_B = {0, 0, 1};
  Rng a(3), b(3), c(4);
  const auto first = PlaceRoom(*shapes_, cell, a), again = PlaceRoom(*shapes_, cell, b),
             other = PlaceRoom(*shapes_, cell, c);
  ASSERT_EQ(first.size(), again.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].shape, again[i].shape);
    EXPECT_EQ(first[i].X_BS.matrix(), again[i].X_BS.matrix());
  }
  EXPECT_TRUE(first.size() != other.size() ||
              first.back().X_BS.matrix() != other.back().X_BS.matrix());
}

// Failures only remove readings or smooth them: a flat wall keeps its depth.
TEST(SensorFailures, FlatWallKeepsItsDepth) {
  int with_holes = 0, unchanged = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Image<float> depth_m(80, 60);
    for (float& z : depth_m.pixels()) z = 1.25f;
    Rng rng(seed);
    ApplyFailures(rng, depth_m);
    int holes = 0;
    for (const float z : depth_m.pixels()) {
      holes += z == 0;
      if (z != 0) {
        EXPECT_NEAR(z, 1.25f, 1e-6);
      }
    }
    with_holes += holes > 0;
    unchanged += holes == 0;
  }
  EXPECT_GT(with_holes, 10);
  EXPECT_GT(unchanged, 10);
}

TEST(SensorFailures, VariedProfileIsValidAndLosesMore) {
  SensorProfile profile = LoadSensorProfile("kinect_v1");
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const SensorProfile varied = VariedProfile(profile, rng);
    EXPECT_GE(varied.random_dropout, profile.random_dropout);
    EXPECT_GE(varied.edge_dropout, profile.edge_dropout);
    EXPECT_LE(varied.edge_dropout, 1);
    EXPECT_GE(AxialSigma_m(varied, 1, 0), 0.69 * AxialSigma_m(profile, 1, 0));
    EXPECT_LE(AxialSigma_m(varied, 1, 0), 2.01 * AxialSigma_m(profile, 1, 0));
  }
}

}  // namespace
}  // namespace pickbed::tests
