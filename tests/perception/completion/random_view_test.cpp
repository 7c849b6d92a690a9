#include "perception/completion/random_view.h"

#include <gtest/gtest.h>

#include "perception/completion/completion_input.h"
#include "perception/completion/training_sample.h"
#include "scenes/shape_families/shape_family.h"
#include "tests/perception/completion/solid_views.h"

namespace pickbed::perception {
namespace {

TEST(TracedSolid, DepthOfASphereFollowsTheQuadraticEquation) {
  const CameraIntrinsics k = TestCamera();
  const auto solid = SphereSolid(kSphereRadius_m);
  const Image<float> depth_m = solid->Depth(k, Translation(kSphereCenter_C));
  int differ = 0;
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      const double z_m = SphereDepth_m(k, x, y, kSphereCenter_C, kSphereRadius_m);
      if ((z_m > 0) != (depth_m(x, y) > 0)) {
        ++differ;
      } else {
        EXPECT_NEAR(depth_m(x, y), z_m, 0.002) << x << " " << y;
      }
    }
  }
  EXPECT_LT(differ, 20);  // pixels on the outline
}

TEST(TracedSolid, LowestPointOfASphereIsOneRadiusBelowItsCenter) {
  const auto solid = SphereSolid(0.05f);
  Rng rng(4);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(solid->LowestAlong(rng.UnitVector().cast<float>()), -0.05, 0.002);
  }
}

TEST(RandomView, TheSameSeedGivesTheSameView) {
  const auto solid = SphereSolid(0.05f);
  Rng first(3), second(3);
  const RandomView a = DrawView(*solid, {}, {}, first), b = DrawView(*solid, {}, {}, second);
  EXPECT_EQ(a.view.depth_m, b.view.depth_m);
  EXPECT_EQ(a.view.segment, b.view.segment);
  EXPECT_EQ(first.Next(), second.Next());
}

TEST(RandomView, AnOccluderHidesTheStatedShareAndIsNearer) {
  const auto solid = SphereSolid(0.05f);
  RandomViewOptions options;
  options.eroded_share = 0;
  options.occluded_share = 1;
  Rng rng(5);
  for (int i = 0; i < 20; ++i) {
    const RandomView drawn = DrawView(*solid, {}, options, rng);
    ASSERT_TRUE(drawn.is_occluded);
    const Image<float> all_m = solid->Depth(drawn.view.intrinsics, drawn.X_CO);
    int seen = 0, hidden = 0;
    for (size_t p = 0; p < all_m.size(); ++p) {
      if (!(all_m.pixels()[p] > 0)) continue;
      seen += drawn.view.segment.pixels()[p];
      if (!drawn.view.occluders.pixels()[p]) continue;
      ++hidden;
      EXPECT_LT(drawn.view.depth_m.pixels()[p], all_m.pixels()[p]);
    }
    const double share = static_cast<double>(hidden) / (seen + hidden);
    EXPECT_GT(share, 0.15);
    EXPECT_LT(share, 0.55);
  }
}

TEST(RandomView, AKnownFloorIsBelowTheSolid) {
  const auto solid = SphereSolid(0.05f);
  RandomViewOptions options;
  options.floor_share = 1;
  Rng rng(6);
  for (int i = 0; i < 20; ++i) {
    const RandomView drawn = DrawView(*solid, {}, options, rng);
    ASSERT_TRUE(drawn.view.floor);
    const Eigen::Vector3f center_C = drawn.X_CO.translation().cast<float>();
    EXPECT_GT(drawn.view.floor->Height_m(center_C), 0.048);
  }
}

// What the frame and the known-empty space cut off limits every completion.
TEST(RandomView, CubesOfSampledShapesHoldAlmostAllOfTheirVolume) {
  const char* names[] = {"carton", "bolt", "tube"};
  double inside = 0, lost = 0;
  Rng rng(7);
  for (const char* name : names) {
    const auto solid = SolidOf(SampleShape(FindShapeFamily(name), ShapeSplit::kSeen, 1).solid);
    for (int view = 0; view < 8; ++view) {
      RandomViewOptions options;
      options.occluded_share = 0;
      const RandomView drawn = DrawView(*solid, {}, options, rng);
      const CompletionInput input(drawn.view);
      std::vector<Eigen::Vector3f> points(400);
      std::vector<uint8_t> is_inside(points.size());
      for (Eigen::Vector3f& p : points) {
        const Eigen::Array3d share(rng.Uniform(), rng.Uniform(), rng.Uniform());
        p = solid->box_O().min() + (share.cast<float>() * solid->box_O().sizes().array()).matrix();
      }
      solid->Inside(points, is_inside);
      for (size_t i = 0; i < points.size(); ++i) {
        if (!is_inside[i]) continue;
        ++inside;
        const Eigen::Vector3f p_C = drawn.X_CO.cast<float>() * points[i];
        const Eigen::Array3f share = (p_C - input.cube().origin_C).array() / input.cube().side_m;
        const bool in_cube = share.minCoeff() >= 0 && share.maxCoeff() <= 1;
        lost += !in_cube || input.IsKnownEmpty(p_C);
      }
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_LT(lost / inside, 0.05);
}

}  // namespace
}  // namespace pickbed::perception
