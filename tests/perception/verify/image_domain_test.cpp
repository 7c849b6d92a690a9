#include "perception/verify/image_domain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(LogitPenalty, IsZeroInsideAndNeverFalls) {
  EXPECT_EQ(LogitPenalty({0.2, 0.002, 0.5}, 60, 0), 0);
  double last = 0;
  for (double holes = 0; holes <= 1; holes += 0.1) {
    const double penalty = LogitPenalty({holes, 0.002, 0.5}, 60, 0);
    EXPECT_GE(penalty, last);
    last = penalty;
  }
  EXPECT_GT(last, 0);
  EXPECT_GT(LogitPenalty({0, 0.02, 0}, 60, 0), LogitPenalty({0, 0.01, 0}, 60, 0));
  EXPECT_GT(LogitPenalty({0, 0, 1.5}, 60, 0), 0);
  EXPECT_GT(LogitPenalty({}, 5, 0), LogitPenalty({}, 10, 0));
  EXPECT_GT(LogitPenalty({0, 0, 0, 45}, 30, 0), LogitPenalty({}, 30, 0));
  EXPECT_EQ(LogitPenalty({}, 60, 0.2), 0);
  EXPECT_GT(LogitPenalty({}, 60, 0.8), LogitPenalty({}, 60, 0.5));
}

TEST(DiameterInImage, IsTheDistanceOfTheProjectedEnds) {
  const CameraIntrinsics camera(200, 100, 90, 90, 99.5, 49.5);
  const Pose X_CO = Translation({0.2, -0.1, 0.5});
  const Eigen::Vector2d left = Project(camera, X_CO * Eigen::Vector3d(-0.03, 0, 0));
  const Eigen::Vector2d right = Project(camera, X_CO * Eigen::Vector3d(0.03, 0, 0));
  EXPECT_NEAR(DiameterInImage_px(camera, 0.06, X_CO), (right - left).norm(), 1e-9);
  EXPECT_TRUE(std::isfinite(DiameterInImage_px(camera, 0.06, Translation({0, 0, 0}))));
}

TEST(OutsideShare, IsTheShareOfTheNearSideBeyondTheEdge) {
  const CameraIntrinsics camera(200, 100, 100, 100, 99.5, 49.5);
  const ModelPoints plate = MakeModelPoints(*ObjectOf(BoxMesh({0.2, 0.2, 0.002}, {0, 0, 0})));
  const auto share = [&](double x, double y) {
    return OutsideShare(camera, plate, Translation({x, y, 1}));
  };
  EXPECT_EQ(share(0, 0), 0);
  EXPECT_EQ(share(0.89, 0), 0);  // the ball about the plate reaches outside
  EXPECT_NEAR(share(1, 0), 0.5, 0.05);
  EXPECT_NEAR(share(-1, 0), 0.5, 0.05);
  EXPECT_NEAR(share(0, 0.55), 0.75, 0.05);
  EXPECT_NEAR(share(1, -0.5), 0.75, 0.05);
  EXPECT_EQ(share(1.2, 0), 1);
  EXPECT_EQ(share(3, 3), 1);
  EXPECT_EQ(OutsideShare(camera, plate, Translation({0, 0, -1})), 1) << "behind the camera";
}

// A known bin leaves no surroundings whose details look like a small object.
TEST(DomainOf, SmallObjectsNeedAKnownBackground) {
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(BoxMesh({0.1, 0.1, 0.02}, Eigen::Vector3d::Zero()), Translation({0, 0, 0.5}));
  OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  EXPECT_EQ(DomainOf(cloud).min_diameter_px, kMinRoomDiameter_px);
  cloud.background = BackgroundKind::kKnown;
  EXPECT_EQ(DomainOf(cloud).min_diameter_px, kMinDiameter_px);
}

// Holes count only between readings: the empty image beside an object is no failure.
TEST(DomainOf, EmptySurroundingsAreNoHoles) {
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(BoxMesh({0.1, 0.1, 0.02}, Eigen::Vector3d::Zero()), Translation({0, 0, 0.5}));
  RgbdFrame frame = scene.frame();
  EXPECT_LT(DomainOf(BuildCloud(frame, std::nullopt, kKeepAll)).hole_share, 0.02);
  int seen = 0;
  for (float& z : frame.depth_m.pixels()) {
    if (z > 0 && ++seen % 5 > 1) z = 0;
  }
  const ImageDomain domain = DomainOf(BuildCloud(frame, std::nullopt, kKeepAll));
  EXPECT_GT(domain.hole_share, kMaxHoleShare);
  ASSERT_EQ(DomainWarnings(domain).size(), 1u);
  EXPECT_THAT(DomainWarnings(domain).front(), HasSubstr("% of the depth is missing"));
}

// A plane that the camera looks along, with readings up to `far_m`.
OrganizedCloud AlongAPlane(float tilt_rad, float far_m) {
  OrganizedCloud cloud;
  cloud.background = BackgroundKind::kFitted;
  const Eigen::Vector3f normal_C(0, -std::sin(tilt_rad), -std::cos(tilt_rad));
  const Eigen::Vector3f along_C(0, -std::cos(tilt_rad), std::sin(tilt_rad));
  const Eigen::Vector3f start_C(0, 0.1f, 0.7f);
  cloud.planes = {{normal_C, normal_C.dot(start_C)}};
  for (int i = 0; i < 1000; ++i) {
    const float share = static_cast<float>(i) / 1000;
    cloud.points_C.push_back(start_C + share * (far_m - start_C.z()) / along_C.z() * along_C);
  }
  return cloud;
}

TEST(DomainOf, ALongFloorTiltsTheCameraAndTheWallOfABinDoesNot) {
  EXPECT_NEAR(DomainOf(AlongAPlane(1.4f, 2.5f)).tilt_rad, 1.4, 1e-4);
  EXPECT_NEAR(DomainOf(AlongAPlane(1.4f, 1.3f)).tilt_rad, 1.4, 1e-4);
  EXPECT_EQ(DomainOf(AlongAPlane(1.4f, 0.85f)).tilt_rad, 0);
  EXPECT_EQ(DomainOf(AlongAPlane(1.4f, 1)).tilt_rad, 0);
  EXPECT_NEAR(DomainOf(AlongAPlane(0.8f, 0.85f)).tilt_rad, 0.8, 1e-4) << "an allowed tilt";
  OrganizedCloud known = AlongAPlane(1.4f, 0.85f);
  known.background = BackgroundKind::kKnown;
  EXPECT_NEAR(DomainOf(known).tilt_rad, 1.4, 1e-4) << "the floor is known";
}

}  // namespace
}  // namespace pickbed::tests
