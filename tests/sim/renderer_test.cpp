#include "sim/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "render_support.h"
#include "scenes/check.h"
#include "scenes/random.h"

namespace pickbed {
namespace {

using test::BoxMesh;
using test::RectangleMesh;
using test::SphereMesh;
using test::TestCamera;

constexpr double kDepthTolerance_m = 2e-5;

// Depth of the plane n.p = d along the ray of a pixel.
double PlaneDepth(const CameraIntrinsics& k, int u, int v, const Eigen::Vector3d& n, double d) {
  return d / n.dot(BackProject(k, u, v, 1.0));
}

TEST(Renderer, TiltedPlaneHasClosedFormDepthAtPixelCentres) {
  Renderer renderer;
  const int mesh = renderer.AddMesh(RectangleMesh(-3, -3, 3, 3));
  Camera camera = TestCamera(160, 120, 150);
  camera.intrinsics.fx = 140;
  camera.intrinsics.cx = 70.25;
  camera.intrinsics.cy = 66.5;
  const Pose X_CO = Translation({0.1, -0.05, 0.9}) *
                    Pose(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 0.5, 0.2).normalized()));
  const RenderedImage image = renderer.Render(camera, std::vector{RenderInstance{mesh, X_CO, 7}});
  const Eigen::Vector3d n = X_CO.linear().col(2);
  double worst_m = 0;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const double expected = PlaneDepth(camera.intrinsics, u, v, n, n.dot(X_CO.translation()));
      worst_m = std::max(worst_m, std::abs(image.depth_m(u, v) - expected));
      ASSERT_EQ(image.ids(u, v), 7);
    }
  }
  RecordProperty("worst_um", std::to_string(1e6 * worst_m));
  EXPECT_LT(worst_m, kDepthTolerance_m);
}

}  // namespace
}  // namespace pickbed
