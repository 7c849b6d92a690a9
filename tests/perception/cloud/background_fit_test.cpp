#include "perception/cloud/background_fit.h"

#include <gtest/gtest.h>

#include "perception/cloud/organized_cloud.h"
#include "scenes/camera/camera.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A bin on a table, rotated about its vertical axis. The camera sees it from the side.
class UnknownBin : public ::testing::TestWithParam<double> {
 protected:
  UnknownBin() : scene_(SmallCamera()) {
    background_.X_CB = kX_CW * Pose(Eigen::AngleAxisd(GetParam(), Eigen::Vector3d::UnitZ()));
    scene_.AddMesh(BinMesh(background_.bin), background_.X_CB);
  }
  // The table is below the bin's floor.
  void AddTable() {
    scene_.AddPlane(kX_CW.linear() * Eigen::Vector3d::UnitZ(),
                    kX_CW * Eigen::Vector3d(0, 0, -background_.bin.wall_m));
  }
  void Add(const Eigen::Vector3d& size_m, const Eigen::Vector3d& center_B, double rotation_rad) {
    const Pose X_BO =
        Translation(center_B) * Pose(Eigen::AngleAxisd(rotation_rad, Eigen::Vector3d::UnitZ()));
    scene_.AddMesh(BoxMesh(size_m, Eigen::Vector3d::Zero()), background_.X_CB * X_BO);
  }
  // Compares with the segmentation of the same frame with a known bin. Returns the share of the
  // objects' pixels that are lost, and the share of the other pixels that are taken for foreground.
  struct Mistakes {
    double lost = 0, taken = 0;
  };
  Mistakes MistakesIn(const RgbdFrame& frame) const {
    const OrganizedCloud known = BuildCloud(frame, background_);
    const OrganizedCloud found = BuildCloud(frame, std::nullopt);
    const double objects = static_cast<double>(known.foreground_pixels.size());
    int lost = 0, taken = 0;
    for (size_t i = 0; i < known.foreground.size(); ++i) {
      lost += known.foreground.data()[i] && !found.foreground.data()[i];
      taken += !known.foreground.data()[i] && found.foreground.data()[i];
    }
    return {lost / objects, taken / (static_cast<double>(known.foreground.size()) - objects)};
  }

  const Pose kX_CW = LookAt({0.05, -0.25, 0.85}, {0, 0, 0}, {0, 0, 1}).inverse();
  KnownBackground background_;
  SyntheticDepth scene_;
};

TEST_P(UnknownBin, WallsAndFloorAreFound) {
  AddTable();
  Add({0.10, 0.03, 0.03}, {0.03, 0.02, 0.016}, 0.4);
  Add({0.08, 0.05, 0.02}, {-0.09, -0.05, 0.011}, 1.1);
  Add({0.03, 0.03, 0.09}, {-0.02, 0.08, 0.046}, 0.2);
  Add({0.05, 0.05, 0.05}, {0.10, -0.08, 0.026}, 2.0);
  Rng rng(7);
  for (const RgbdFrame& frame : {scene_.frame(), WithNoise(scene_.frame(), 0.0005, rng)}) {
    const Mistakes mistakes = MistakesIn(frame);
    EXPECT_LT(mistakes.lost, 0.02);
    EXPECT_LT(mistakes.taken, 0.01);  // the walls are a fifth of these pixels
  }
}

// There is no table, so no plane contains a quarter of the points.
TEST_P(UnknownBin, NearlyHiddenFloorIsFound) {
  for (int x = -3; x <= 3; ++x) {
    for (int y = -2; y <= 2; ++y) {
      Add({0.045, 0.045, 0.02 + 0.003 * ((3 * x + 5 * y + 20) % 7)}, {0.054 * x, 0.054 * y, 0.02},
          0.1 * x);
    }
  }
  const Mistakes mistakes = MistakesIn(scene_.frame());
  EXPECT_LT(mistakes.lost, 0.02);
  EXPECT_LT(mistakes.taken, 0.04);  // the outer side of the nearest wall is 0.03
}

// Three walls show their inner side; at larger rotations two do.
INSTANTIATE_TEST_SUITE_P(Rotations, UnknownBin, ::testing::Values(0.0, 0.3, -0.25));

// Everything in front of an empty table must be foreground.
void ExpectObjectsKept(const RgbdFrame& frame, const Image<float>& table_m) {
  const OrganizedCloud cloud = BuildCloud(frame, std::nullopt);
  int objects = 0, kept = 0;
  for (size_t i = 0; i < table_m.size(); ++i) {
    const bool is_object = frame.depth_m.data()[i] < table_m.data()[i] - 0.01f;
    objects += is_object;
    kept += is_object && cloud.foreground.data()[i];
  }
  EXPECT_GT(objects, 2000);
  EXPECT_GT(kept, 0.98 * objects);
}

// Outward sides of an object are not walls, even if they are arranged like the walls of a bin.
TEST(FitBackground, SidesOfABoxOnATableAreKept) {
  for (const double rotation_rad : {0.0, 0.5}) {
    const Pose X_CW = LookAt({0, -0.4, 0.5}, {0, 0, 0}, {0, 0, 1}).inverse();
    SyntheticDepth scene(SmallCamera());
    scene.AddPlane(X_CW.linear() * Eigen::Vector3d::UnitZ(), X_CW.translation());
    const Image<float> table_m = scene.frame().depth_m;
    scene.AddMesh(BoxMesh({0.15, 0.12, 0.10}, {0, 0, 0.05}),
                  X_CW * Pose(Eigen::AngleAxisd(rotation_rad, Eigen::Vector3d::UnitZ())));
    ExpectObjectsKept(scene.frame(), table_m);
  }
}

// Parallel rods have their edges on one line and their ends on another.
TEST(FitBackground, RodsOnATableAreKept) {
  const Pose X_CW = LookAt({0, -0.2, 0.6}, {0, 0, 0}, {0, 0, 1}).inverse();
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane(X_CW.linear() * Eigen::Vector3d::UnitZ(), X_CW.translation());
  const Image<float> table_m = scene.frame().depth_m;
  for (int i = -2; i <= 2; ++i) {
    scene.AddMesh(BoxMesh({0.02, 0.15, 0.02}, {0.05 * i, 0, 0.01}), X_CW);
    scene.AddMesh(BoxMesh({0.02, 0.02, 0.08}, {0.05 * i, 0.12, 0.04}), X_CW);
  }
  ExpectObjectsKept(scene.frame(), table_m);
}

// From far away, the plane with most points passes through the objects. The table just behind it
// shows that it is not the table.
TEST(FitBackground, FlatObjectsThatCoverMostOfATableAreKept) {
  const Pose X_CW = LookAt({0, -0.4, 1.9}, {0, 0, 0}, {0, 0, 1}).inverse();
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane(X_CW.linear() * Eigen::Vector3d::UnitZ(), X_CW.translation());
  const Image<float> table_m = scene.frame().depth_m;
  for (int x = -5; x <= 5; ++x) {
    for (int y = -4; y <= 4; ++y) {
      scene.AddMesh(BoxMesh({0.20, 0.20, 0.04}, {0.25 * x, 0.25 * y, 0.02}), X_CW);
    }
  }
  Rng rng(3);
  const RgbdFrame frame = WithNoise(scene.frame(), 0.0005, rng);
  ExpectObjectsKept(frame, table_m);
  EXPECT_EQ(BuildCloud(frame, std::nullopt).planes.size(), 1u) << "the table is found";
}

// The floor around a low board is just behind it, too, but beside it.
TEST(FitBackground, ABoardOnAFloorIsBackground) {
  const Pose X_CW = LookAt({0, -0.4, 1.9}, {0, 0, 0}, {0, 0, 1}).inverse();
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane(X_CW.linear() * Eigen::Vector3d::UnitZ(), X_CW.translation());
  scene.AddMesh(BoxMesh({1.35, 1.05, 0.04}, {0, 0, 0.02}), X_CW);
  for (int x = -2; x <= 2; ++x) {
    scene.AddMesh(BoxMesh({0.10, 0.10, 0.10}, {0.25 * x, 0.1, 0.09}), X_CW);
  }
  Rng rng(3);
  const RgbdFrame frame = WithNoise(scene.frame(), 0.0005, rng);
  const OrganizedCloud cloud = BuildCloud(frame, std::nullopt);
  ASSERT_EQ(cloud.planes.size(), 1u);
  const Eigen::Vector3d top_C = X_CW * Eigen::Vector3d(0, 0, 0.04);
  EXPECT_NEAR(cloud.planes[0].SignedDistance(top_C.cast<float>()), 0, 0.01);
}

TEST(FitBackground, DepthInAWrongUnitGivesNoWalls) {
  std::vector<Eigen::Vector3f> points_C;
  for (int i = 0; i < 4000; ++i) {
    const float x = 0.01f * (i % 80), y = 0.01f * (i / 80);
    points_C.push_back(1e-4f * Eigen::Vector3f(x, y, 1 - (i % 7 == 0 ? 0.3f * x : 0)));
  }
  EXPECT_EQ(FitBackground(points_C, {}).size(), 1u) << "only the plane with the most points";
}

TEST(FitBackground, TooFewPointsGiveNoPlane) {
  EXPECT_TRUE(FitBackground({}, {}).empty());
  EXPECT_TRUE(FitBackground({{0, 0, 1}, {0, 0.1f, 1}}, {}).empty());
  // Points on one line define no plane.
  EXPECT_TRUE(FitBackground({{0, 0, 1}, {0, 0.1f, 1}, {0, 0.2f, 1}, {0, 0.3f, 1}}, {}).empty());
}

}  // namespace
}  // namespace pickbed::tests
