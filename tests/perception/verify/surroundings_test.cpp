#include <gtest/gtest.h>

#include "perception/verify/physical_consistency.h"
#include "perception/verify/pose_features.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A cube of 40 mm in a bin of 300 x 200 x 60 mm, seen from 0.5 m vertically above its floor.
class CubeInBin : public testing::Test {
 protected:
  CubeInBin() {
    background_.bin.inner_size_m = {0.3, 0.2, 0.06};
    background_.X_CB.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    background_.X_CB.translation() = Eigen::Vector3d(0, 0, 0.5);
  }

  // Measures the cube with its center at p_B.
  Containment At(const Eigen::Vector3d& p_B) const {
    return MeasureContainment(cloud(), model_, background_.X_CB * Translation(p_B));
  }
  VerifyFeatures FeaturesAt(const Eigen::Vector3d& p_B) const {
    FitReport fit;
    return ComputeVerifyFeatures(cloud(), model_, background_.X_CB * Translation(p_B), {}, {}, 0,
                                 fit);
  }
  OrganizedCloud cloud() const {
    SyntheticDepth scene(SmallCamera());
    scene.AddPlane({0, 0, -1}, {0, 0, 0.5});
    return BuildCloud(scene.frame(), background_);
  }

  KnownBackground background_;
  ModelPoints model_ =
      MakeModelPoints(*ObjectOf(BoxMesh({0.04, 0.04, 0.04}, Eigen::Vector3d::Zero())));
};

TEST_F(CubeInBin, HeightAndPenetrationOfTheFloorAreMeasured) {
  EXPECT_TRUE(At({0, 0, 0.02}).has_floor);
  EXPECT_NEAR(At({0, 0, 0.02}).outside_m, 0, 1e-5);
  EXPECT_NEAR(At({0, 0, 0.02}).height_m, 0, 1e-5);
  EXPECT_NEAR(At({0, 0, 0.05}).height_m, 0.03, 1e-5);
  EXPECT_NEAR(At({0, 0, 0.012}).outside_m, 0.008, 1e-5);
  EXPECT_NEAR(At({0, 0, 0.012}).height_m, -0.008, 1e-5);
}

TEST_F(CubeInBin, PenetrationOfWallsEndsAtTheRim) {
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(At({side * 0.135, 0, 0.03}).outside_m, 0.005, 1e-5);
    EXPECT_NEAR(At({0, side * 0.09, 0.03}).outside_m, 0.01, 1e-5);
    EXPECT_EQ(At({side * 0.135, 0, 0.0805}).outside_m, 0) << "it leans over the rim";
  }
}

TEST_F(CubeInBin, TableHasNoWalls) {
  background_.bin.inner_size_m.z() = 0;
  EXPECT_EQ(At({0.3, 0, 0.03}).outside_m, 0);
  EXPECT_NEAR(At({0.3, 0, 0.015}).outside_m, 0.005, 1e-5);
}

TEST_F(CubeInBin, FeaturesAreInDiameters) {
  const double diameter_m = model_.diameter_m;
  EXPECT_NEAR(FeaturesAt({0, 0, 0.012})[kOutsideFeature], 0.008 / diameter_m, 1e-3);
  EXPECT_NEAR(FeaturesAt({0, 0, 0.02})[kRestingFeature], 1, 1e-3);
  EXPECT_LT(FeaturesAt({0, 0, 0.05})[kRestingFeature], 0.01);
}

TEST_F(CubeInBin, FittedFloorCountsLikeAKnownFloor) {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane({0, 0, -1}, {0, 0, 0.5});
  const OrganizedCloud fitted = BuildCloud(scene.frame(), std::nullopt);
  const Containment through =
      MeasureContainment(fitted, model_, background_.X_CB * Translation({0, 0, 0.012}));
  EXPECT_TRUE(through.has_floor);
  EXPECT_NEAR(through.outside_m, 0.008, 1e-3);
}

TEST_F(CubeInBin, NothingIsOutsideWithoutABackground) {
  SyntheticDepth scene(SmallCamera());
  scene.AddSphere({0, 0, 0.4}, 0.03);
  const OrganizedCloud no_background =
      BuildCloud(scene.frame(), std::nullopt, {.min_plane_share = 1});
  const Containment found = MeasureContainment(no_background, model_, Translation({0, 0, 0.4}));
  EXPECT_FALSE(found.has_floor);
  EXPECT_EQ(found.outside_m, 0);
}

}  // namespace
}  // namespace pickbed::tests
