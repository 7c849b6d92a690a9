#include "eval/shapes/segment_shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

TEST(ShapeOfMesh, HasTheVolumeAndThePlaceOfTheMesh) {
  const TriangleMesh mesh = BracketMesh();
  const Pose X_WO = Perturbed(Pose::Identity(), {1, 2, 3}, 40, {0.1, -0.2, 0.3});
  const grasp::OccupancyShape shape = ShapeOfMesh(mesh, X_WO);
  const double cells = std::accumulate(shape.occupancy.begin(), shape.occupancy.end(), 0.0);
  const MassProperties solid = UniformMassProperties(mesh, 1);
  EXPECT_NEAR(cells * std::pow(shape.cell_m, 3) / solid.volume_m3, 1, 0.05);
  Vector3d sum = Vector3d::Zero();
  for (int z = 0; z < shape.size; ++z) {
    for (int y = 0; y < shape.size; ++y) {
      for (int x = 0; x < shape.size; ++x) {
        sum += shape.At(x, y, z) * (shape.X_WV * shape.Center_V(x, y, z));
      }
    }
  }
  EXPECT_LT((sum / cells - X_WO * solid.com_O).norm(), shape.cell_m);
}

TEST(ViewOf, IsAWindowOfTheImageWithTheSamePoints) {
  SyntheticDepth depth(SmallCamera());
  depth.AddSphere({0.05, 0.02, 0.6}, 0.02);
  const RgbdFrame& frame = depth.frame();
  Image<uint16_t> labels(frame.depth_m.width(), frame.depth_m.height());
  perception::ObjectSegment segment{0, {1000, 1000, 0, 0}, {}};
  int x1 = 0, y1 = 0;
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      if (!(frame.depth_m(x, y) > 0)) continue;
      labels(x, y) = 3;
      segment.box.x = std::min(segment.box.x, x);
      segment.box.y = std::min(segment.box.y, y);
      x1 = std::max(x1, x + 1);
      y1 = std::max(y1, y + 1);
    }
  }
  segment.box.width = x1 - segment.box.x;
  segment.box.height = y1 - segment.box.y;
  const perception::SegmentView view = ViewOf(frame, labels, segment, 3, std::nullopt);
  EXPECT_LT(view.depth_m.width(), frame.depth_m.width());
  int pixels = 0;
  for (int y = 0; y < view.depth_m.height(); ++y) {
    for (int x = 0; x < view.depth_m.width(); ++x) {
      if (view.segment(x, y) == 0) continue;
      ++pixels;
      const Vector3d p_C = BackProject(view.intrinsics, x, y, view.depth_m(x, y));
      EXPECT_NEAR((p_C - Vector3d(0.05, 0.02, 0.6)).norm(), 0.02, 1e-5);
    }
  }
  EXPECT_EQ(pixels, std::count(labels.pixels().begin(), labels.pixels().end(), 3));
}

TEST(SegmentShapes, RefusesUnknownNamesAndTruthWithoutATrial) {
  EXPECT_THAT(ErrorOf([] { SegmentShapes("convex", kTrueShapes); }), HasSubstr("convexity"));
  EXPECT_THAT(ErrorOf([] { SegmentShapes("convexity", "magic"); }), HasSubstr("magic"));
  SegmentShapes shapes("convexity", kTrueShapes);
  SyntheticDepth depth(SmallCamera());
  const PlannerInput input{depth.frame(), Pose::Identity(), std::nullopt};
  EXPECT_THAT(ErrorOf([&] { shapes.Shapes(input, 5); }), HasSubstr("truth"));
}

}  // namespace
}  // namespace pickbed::tests
