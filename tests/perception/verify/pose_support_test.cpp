#include "perception/verify/pose_support.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/verify/depth_evidence.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

PoseSupport SupportOf(const TriangleMesh& mesh_O, const RgbdFrame& frame, const Pose& X_CO) {
  EvidenceScratch scratch;
  PoseSupportMeasure measure;
  const DepthEvidenceOf evidence(*ObjectOf(mesh_O));
  evidence(BuildCloud(frame, std::nullopt, kKeepAll), X_CO, scratch, std::nullopt, &measure);
  return measure.Finish();
}

// Readings on a plane hold a translation and two rotations; readings on three orthogonal planes
// hold all six directions.
TEST(PoseSupportMeasure, PlaneLeavesThreeDirectionsFreeAndCornerNone) {
  const auto support_of = [](int planes) {
    PoseSupportMeasure measure;
    measure.Begin({0, 0, 1}, 0.1f, 0.001f);
    for (int axis = 0; axis < planes; ++axis) {
      for (int i = -5; i <= 5; ++i) {
        for (int j = -5; j <= 5; ++j) {
          Eigen::Vector3f p_C(0, 0, 1), normal_C = Eigen::Vector3f::Zero();
          normal_C[axis] = 1;
          p_C[axis] += 0.05f;
          p_C[(axis + 1) % 3] += 0.01f * static_cast<float>(i);
          p_C[(axis + 2) % 3] += 0.01f * static_cast<float>(j);
          measure.AddCovered();
          measure.AddAgreeing(p_C, normal_C);
        }
      }
    }
    return measure.Finish();
  };
  EXPECT_NEAR(support_of(1).second_weakest, 0, 1e-3);
  EXPECT_NEAR(support_of(2).weakest, 0, 1e-3);
  EXPECT_GT(support_of(3).weakest, 0.1);
}

// The information of a square of readings in the direction of its normal is 1 per pixel, and about
// its axes the mean squared distance over the squared radius.
TEST(PoseSupportMeasure, EigenvaluesAreMeanSquares) {
  PoseSupportMeasure measure;
  measure.Begin(Eigen::Vector3f::UnitZ(), 1, 0.001f);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      Eigen::Vector3f p_C(0, 0, 1), normal_C = Eigen::Vector3f::Zero();
      normal_C[axis] = 1;
      p_C[(axis + 1) % 3] += 0.5f * side;
      measure.AddCovered();
      measure.AddAgreeing(p_C, normal_C);
    }
  }
  // Each translation is held by 2 of 6 readings, each rotation by 2 of 6 at half the radius.
  EXPECT_NEAR(measure.Finish().weakest, std::sqrt(0.25 * 2 / 6), 1e-5);
}

// A bar that faces the camera. An occluder hides its ends or its center.
class BarView : public testing::Test {
 protected:
  PoseSupport WithOccluder(double from_m, double to_m, bool mirrored) const {
    SyntheticDepth scene(SmallCamera());
    scene.AddPlane({0, 0, -1}, {0, 0, 0.6});
    scene.AddMesh(bar_, X_CO_);
    for (const double side : {-1.0, 1.0}) {
      if (side < 0 && !mirrored) continue;
      const double width_m = to_m - from_m;
      scene.AddMesh(BoxMesh({width_m, 0.05, 0.02}, {side * (from_m + width_m / 2), 0, 0}),
                    Translation({0, 0, 0.36}));
    }
    return SupportOf(bar_, scene.frame(), X_CO_);
  }
  TriangleMesh bar_ = BoxMesh({0.12, 0.02, 0.02}, Eigen::Vector3d::Zero());
  Pose X_CO_ = Translation({0, 0, 0.4});
};

TEST_F(BarView, HiddenEndsLeaveTheAxisFree) {
  const PoseSupport ends_hidden = WithOccluder(0.04, 0.08, true);
  const PoseSupport center_hidden = WithOccluder(-0.02, 0.02, false);
  EXPECT_GT(center_hidden.weakest, 0.05);
  EXPECT_LT(ends_hidden.weakest, 0.25 * center_hidden.weakest);
  EXPECT_GT(center_hidden.outline_seen, 0.9);
}

// A slab in front of a wall, and one whose front is flush with it.
TEST(PoseSupport, WallContinuesThePlaneOfAFlushSlab) {
  const TriangleMesh slab = BoxMesh({0.061, 0.041, 0.02}, {0, 0, 0.01});
  const Pose X_CO = Translation({0, 0, 0.4});
  SyntheticDepth flush(SmallCamera());
  flush.AddPlane({0, 0, -1}, X_CO.translation());
  const PoseSupport in_wall = SupportOf(slab, flush.frame(), X_CO);
  EXPECT_GT(in_wall.coplanar, 0.1);
  EXPECT_EQ(in_wall.outline_seen, 0);

  SyntheticDepth separate(SmallCamera());
  separate.AddPlane({0, 0, -1}, {0, 0, 0.5});
  separate.AddMesh(slab, X_CO);
  const PoseSupport before_wall = SupportOf(slab, separate.frame(), X_CO);
  EXPECT_EQ(before_wall.coplanar, 0);
  EXPECT_EQ(before_wall.outline_seen, 1);
}

TEST(PoseSupport, PoseWithoutAgreeingReadingsHasNone) {
  SyntheticDepth empty(SmallCamera());
  empty.AddPlane({0, 0, -1}, {0, 0, 0.6});
  const PoseSupport support = SupportOf(BracketMesh(), empty.frame(), BracketPose());
  EXPECT_EQ(support.weakest, 0);
  EXPECT_EQ(support.outline_seen, 0);
  EXPECT_EQ(support.coplanar, 0);
}

}  // namespace
}  // namespace pickbed::tests
