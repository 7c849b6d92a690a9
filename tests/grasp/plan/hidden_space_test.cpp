#include "grasp/plan/hidden_space.h"

#include <gtest/gtest.h>

#include "tests/grasp/plan/plan_fixture.h"

namespace pickbed::tests {
namespace {

// An image from 1 m above the floor. A plate 0.1 m above the floor covers the half with x > 0.
class HiddenSpaceTest : public PlanFixture {
 protected:
  static constexpr double kBehind_m = 0.005;

  HiddenSpaceTest() : depth_m_(401, 401, 1.0f) {
    camera_.intrinsics = {401, 401, 500, 500, 200, 200};
    camera_.SetPose(LookAt({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
    for (int v = 0; v < 401; ++v) {
      for (int u = 0; u < 401; ++u) {
        if (camera_.X_WC().linear().col(0).x() * (u - 200) > 0) depth_m_(u, v) = 0.9f;
      }
    }
  }

  HiddenSpace Hidden() const { return {depth_m_, camera_.intrinsics, camera_.X_CW(), kBehind_m}; }

  // Hidden volume of a box of 2 x 2 x 4 cm whose center is at `p_W`, in cm^3.
  double HiddenOf(const Eigen::Vector3d& p_W) const {
    const AxisAlignedBox box{{0, 0, 0}, {0.01, 0.01, 0.02}};
    return 1e6 * Hidden().HiddenVolume_m3({&box, 1}, Translation(p_W), 0.001);
  }

  Camera camera_;
  Image<float> depth_m_;
};

TEST_F(HiddenSpaceTest, SpaceBehindASurfaceIsHidden) {
  EXPECT_NEAR(HiddenOf({0.15, 0, 0.05}), 16, 1e-9) << "all of it is under the plate";
  EXPECT_EQ(HiddenOf({-0.15, 0, 0.05}), 0) << "above the floor in view";
  EXPECT_EQ(HiddenOf({0.15, 0, 0.15}), 0) << "above the plate";
  // The upper part is in front of the plate or less than kBehind_m behind it.
  EXPECT_NEAR(HiddenOf({0.15, 0, 0.1}), 16 * (0.02 - kBehind_m) / 0.04, 1e-9);
  EXPECT_EQ(HiddenOf({0.9, 0, 0.05}), 0) << "outside the image";
}

// The border of the hidden space is the viewing ray along the edge of the plate.
TEST_F(HiddenSpaceTest, BorderOfHiddenSpaceIsAViewingRay) {
  EXPECT_NEAR(HiddenOf({0, 0, 0.05}), 8, 1.0) << "half a pixel is 1 mm of the 20 mm";
}

TEST_F(HiddenSpaceTest, GapsCountAsTheirNearestBorder) {
  for (int v = 150; v < 250; ++v) {
    for (int u = 0; u < 401; ++u) {
      if (depth_m_(u, v) == 0.9f && std::abs(u - 200) < 150) depth_m_(u, v) = 0;
    }
  }
  EXPECT_NEAR(HiddenOf({0.15, 0, 0.05}), 16, 1e-9);
}

TEST_F(HiddenSpaceTest, MeanDepthIsOverTheCrossSectionOfTheFingers) {
  // Two fingers of 1 x 2 cm, one of which is in hidden space by 4 cm, and a palm in view.
  const std::vector<AxisAlignedBox> sweep{{{0, 0, 0}, {0.005, 0.01, 0.02}},
                                          {{-0.3, 0, 0}, {0.005, 0.01, 0.02}},
                                          {{0, 0, 0.2}, {0.05, 0.05, 0.01}}};
  EXPECT_NEAR(Hidden().MeanDepth_m(sweep, Translation({0.15, 0, 0.05}), 0.001), 0.02, 1e-9);
}

// Two equal cubes. The better one is under the plate, so that the hand reaches into hidden space.
TEST_F(HiddenSpaceTest, HandInHiddenSpaceComesLast) {
  AddPose({-0.15, 0, 0.025}, 0.9);
  AddPose({0.15, 0, 0.025}, 1);
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 1);
  const HiddenSpace behind_the_plate = Hidden();
  hidden_ = &behind_the_plate;
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 0);
  depth_m_ = Image<float>(401, 401, 1.0f);
  const HiddenSpace under_the_floor = Hidden();
  hidden_ = &under_the_floor;
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 1);
}

}  // namespace
}  // namespace pickbed::tests
