#include "perception/verify/edge_support.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/objects/object_model.h"
#include "tests/perception/edge_image.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

class EdgeSupportTest : public testing::Test {
 protected:
  EdgeSupportTest() {
    ObjectModel box;
    box.mesh_O = BoxMesh({0.06, 0.04, 0.02}, Eigen::Vector3d::Zero());
    model_ = MakeModelPoints(box);
    cloud_ = CloudWithEdgesOf(camera_, model_, X_CO_);
  }

  const CameraIntrinsics camera_{320, 240, 300, 300, 159.5, 119.5};
  const Pose X_CO_ = Translation({0, 0, 0.3});
  ModelPoints model_;
  OrganizedCloud cloud_;
};

TEST_F(EdgeSupportTest, IsLargestAtTheTruePose) {
  const EdgeSupport there = MeasureEdgeSupport(cloud_, model_, X_CO_);
  const EdgeSupport beside = MeasureEdgeSupport(cloud_, model_, Translation({0.01, 0.01, 0.3}));
  EXPECT_GT(there.visible, 100);
  EXPECT_GT(there.mean, 2 * beside.mean);
}

TEST_F(EdgeSupportTest, EdgesThatFaceAwayAreNotCounted) {
  // The back face has four of the twelve edges, which are a third of the length.
  const int visible = MeasureEdgeSupport(cloud_, model_, X_CO_).visible;
  EXPECT_LT(visible, static_cast<int>(model_.edges.size()));
  EXPECT_GT(visible, static_cast<int>(model_.edges.size()) / 3);
}

TEST_F(EdgeSupportTest, NearerSurfacesHideEdges) {
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) cloud_.depth_m(u, v) = 0.25f;
  }
  EXPECT_EQ(MeasureEdgeSupport(cloud_, model_, X_CO_).visible, 0);
  EXPECT_EQ(MeasureEdgeSupport(cloud_, model_, X_CO_).mean, 0);
}

TEST_F(EdgeSupportTest, ImageWithoutColorGivesNone) {
  cloud_.edges = {};
  EXPECT_EQ(MeasureEdgeSupport(cloud_, model_, X_CO_).visible, 0);
}

TEST_F(EdgeSupportTest, PoseThatIsNotFiniteGivesNone) {
  for (const double wrong : {double(NAN), double(INFINITY), 1e30}) {
    for (const Pose& X_CO : {Translation({wrong, 0, 0.3}), Translation({0, -wrong, 0.3})}) {
      EXPECT_EQ(MeasureEdgeSupport(cloud_, model_, X_CO).visible, 0) << wrong;
    }
  }
}

TEST_F(EdgeSupportTest, ObjectBehindTheCameraGivesNone) {
  EXPECT_EQ(MeasureEdgeSupport(cloud_, model_, Translation({0, 0, -0.3})).visible, 0);
}

}  // namespace
}  // namespace pickbed::tests
