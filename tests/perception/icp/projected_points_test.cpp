#include "perception/icp/projected_points.h"

#include <gtest/gtest.h>

#include <limits>

#include "perception/cloud/projector.h"
#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// The reference moves and projects one point at a time.
TEST(ProjectPoints, EqualsTheSamePointsOneByOne) {
  const CameraIntrinsics camera(64, 48, 60, 55, 31.5, 23.5);
  const Projector project(camera);
  CenteredPose pose;
  pose.R_CO = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  Rng rng(1);
  int seen = 0, unseen = 0;
  for (const double z_m : {0.05, 1.0, 1e30}) {
    pose.center_C = {0.02, -0.1, z_m};
    IcpPoints points;
    points.count = 403;  // the last vector is not full
    for (int i = 0; i < points.count; ++i) {
      for (int k = 0; k < 3; ++k) {
        points.points[k][i] = static_cast<float>(rng.Uniform(-0.6, 0.6));
        points.normals[k][i] = static_cast<float>(rng.Uniform(-1, 1));
      }
    }
    points.points[0][5] = std::numeric_limits<float>::quiet_NaN();
    points.points[1][6] = std::numeric_limits<float>::infinity();
    points.points[2][7] = 3e38f;
    ProjectedPoints projected;
    ProjectPoints(points, pose, camera, projected);
    const Eigen::Matrix3f R = pose.R_CO.cast<float>();
    for (int i = 0; i < points.count; ++i) {
      const Eigen::Vector3f arm = R * At(points.points, i);
      const Eigen::Vector3f p_C = arm + pose.center_C.cast<float>();
      EXPECT_EQ(projected.pixels[i], project(p_C)) << i;
      ++(projected.pixels[i] >= 0 ? seen : unseen);
      if (!p_C.allFinite()) continue;
      EXPECT_EQ(At(projected.arms, i), arm) << i;
      EXPECT_EQ(At(projected.points_C, i), p_C) << i;
      EXPECT_EQ(At(projected.normals_C, i), R * At(points.normals, i)) << i;
    }
  }
  EXPECT_GT(seen, 300);
  EXPECT_GT(unseen, 300);
}

}  // namespace
}  // namespace pickbed::tests
