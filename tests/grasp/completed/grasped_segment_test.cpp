#include "grasp/completed/grasped_segment.h"

#include <gtest/gtest.h>

#include "grasp/grippers/suction_cup.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kEdge_m = 0.03;

CloudScene TwoBoxes() {
  CloudScene scene;
  for (const double x_m : {-0.05, 0.05}) {
    scene.AddBox(Vector3d::Constant(kEdge_m), OnFloor(x_m, 0, kEdge_m, 0));
  }
  return scene;
}

// Straight down at the height of the upper faces, and `deep_m` below them.
Pose Down(double x_m, double y_m, double deep_m) {
  Eigen::Matrix3d R_WG;
  R_WG << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return MakePose(R_WG, {x_m, y_m, kEdge_m - deep_m});
}

TEST(GraspedSegment, IsTheOneBetweenTheFingers) {
  const CloudScene scene = TwoBoxes();
  const ImageSegments image = LeftAndRight(scene);
  const ParallelJaw jaw = SmallJaw();
  const auto index = [&](double x_m) -> int {
    const SegmentMeasures* found =
        GraspedSegment(image, scene.Input(), jaw, Down(x_m, 0, 0.01), kEdge_m);
    return found == nullptr ? -1 : static_cast<int>(found - image.segments.data());
  };
  EXPECT_EQ(index(-0.05), 0);
  EXPECT_EQ(index(0.05), 1);
  EXPECT_EQ(index(0), -1) << "between the boxes";
}

TEST(GraspedSegment, IsTheOneUnderACup) {
  const CloudScene scene = TwoBoxes();
  const ImageSegments image = LeftAndRight(scene);
  const SuctionCup cup;
  EXPECT_EQ(GraspedSegment(image, scene.Input(), cup, Down(0.05, 0, 0), 0), &image.segments[1]);
  EXPECT_EQ(GraspedSegment(image, scene.Input(), cup, Down(0, 0, 0), 0), nullptr);
}

TEST(GraspedSegment, IsNoneOutsideOfTheImageAndWithoutSegments) {
  const CloudScene scene = TwoBoxes();
  const ParallelJaw jaw = SmallJaw();
  const ImageSegments image = LeftAndRight(scene);
  EXPECT_EQ(GraspedSegment(image, scene.Input(), jaw, Down(9, 0, 0), kEdge_m), nullptr);
  EXPECT_EQ(GraspedSegment(image, scene.Input(), jaw, Translation({0, 0, 9}), kEdge_m), nullptr);
  EXPECT_EQ(GraspedSegment({}, scene.Input(), jaw, Down(0.05, 0, 0.01), kEdge_m), nullptr);
}

// The distance does not change along the closing line, nor with the height.
TEST(GraspedSegment, TheOffsetIsAcrossTheClosingLine) {
  const Pose X_WC = OnFloor(0.3, -0.2, 1.8, 0.7);
  SegmentMeasures segment;
  segment.center_C = X_WC.inverse() * Vector3d(0.05, 0, 0.01);
  EXPECT_NEAR(CenterOffset_m(segment, X_WC, Down(0.05, 0.02, 0)), 0.02, 1e-12);
  EXPECT_NEAR(CenterOffset_m(segment, X_WC, Down(0.01, 0.02, 0.005)), 0.02, 1e-12);
  EXPECT_NEAR(CenterOffset_m(segment, X_WC, Down(0.09, 0, 0)), 0, 1e-12);
}

}  // namespace
}  // namespace pickbed::tests
