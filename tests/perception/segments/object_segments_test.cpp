#include "perception/segments/object_segments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kTable_m = 0.62;  // distance of the table from the camera

// A table that faces the camera, and the known bin without walls on it.
class TableScene {
 public:
  explicit TableScene(const CameraIntrinsics& camera = SmallCamera()) : depth_(camera) {
    depth_.AddPlane(-Vector3d::UnitZ(), {0, 0, kTable_m});
  }
  // `center`: on the table, m; z is the height of the center over the table.
  void AddBox(const Vector3d& size_m, const Vector3d& center, double yaw_rad = 0) {
    const Eigen::AngleAxisd yaw(yaw_rad, Vector3d::UnitZ());
    depth_.AddMesh(
        BoxMesh(size_m, Vector3d::Zero()),
        MakePose(yaw.toRotationMatrix(), {center.x(), center.y(), kTable_m - center.z()}));
  }
  void AddSphere(const Vector3d& center, double radius_m) {
    depth_.AddSphere({center.x(), center.y(), kTable_m - center.z()}, radius_m);
  }
  ObjectSegments Segments(const SegmenterOptions& options = {}, double noise_m = 0.0005) const {
    Rng rng(5);
    return SegmentFrame(WithNoise(depth_.frame(), noise_m, rng), Background(), options);
  }
  static KnownBackground Background() {
    Eigen::Matrix3d R_CB;
    R_CB << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    return {Bin{{2, 2, 0}}, MakePose(R_CB, {0, 0, kTable_m})};
  }
  const RgbdFrame& frame() const { return depth_.frame(); }

 private:
  SyntheticDepth depth_;
};

TEST(SegmentCloud, TwoSeparateBoxesAreTwoSegments) {
  TableScene scene;
  scene.AddBox({0.06, 0.05, 0.04}, {-0.06, 0, 0.02}, 0.3);
  scene.AddBox({0.05, 0.05, 0.03}, {0.06, 0.01, 0.015}, -0.5);
  const ObjectSegments found = scene.Segments();
  ASSERT_EQ(found.segments.size(), 2u);
  for (const ObjectSegment& segment : found.segments) {
    EXPECT_NEAR(std::abs(segment.center_C.x()), 0.06, 0.01);
    EXPECT_LT(segment.center_C.z(), kTable_m - 0.02);
  }
}

TEST(SegmentCloud, ConvexBodiesAreOneSegment) {
  TableScene scene;
  scene.AddSphere({0, 0, 0.04}, 0.04);
  EXPECT_EQ(scene.Segments().segments.size(), 1u);
  TableScene box;
  box.AddBox({0.05, 0.08, 0.05}, {0.12, 0.05, 0.025}, 0.4);  // shows three of its faces
  EXPECT_EQ(box.Segments().segments.size(), 1u);
}

// A low and a high box that touch: a step in depth.
TEST(SegmentCloud, ABoxOnTopOfAnotherIsASegmentOfItsOwn) {
  TableScene scene;
  scene.AddBox({0.12, 0.10, 0.03}, {0, 0, 0.015});
  scene.AddBox({0.05, 0.05, 0.03}, {0, 0, 0.045});
  const ObjectSegments found = scene.Segments();
  ASSERT_EQ(found.segments.size(), 2u);
  const uint16_t top = found.labels(160, 120), low = found.labels(160, 96);
  EXPECT_NE(top, 0);
  EXPECT_NE(low, 0);
  EXPECT_NE(top, low);
}

// Two slanted faces that meet in a valley have no step between them.
TEST(SegmentCloud, AConcaveEdgeSeparatesOnlyIfConvexityCounts) {
  SyntheticDepth depth(SmallCamera());
  const Eigen::AngleAxisd left(-0.7, Vector3d::UnitY()), right(0.7, Vector3d::UnitY());
  depth.AddMesh(BoxMesh({0.06, 0.08, 0.02}, {0.03, 0, 0.01}),
                MakePose(right.toRotationMatrix(), {0, 0, 0.59}));
  depth.AddMesh(BoxMesh({0.06, 0.08, 0.02}, {-0.03, 0, 0.01}),
                MakePose(left.toRotationMatrix(), {0, 0, 0.59}));
  const auto count = [&](const std::string& method) {
    return SegmentFrame(depth.frame(), TableScene::Background(), SegmenterNamed(method).options())
        .segments.size();
  };
  const bool is_valley = depth.frame().depth_m(160, 120) > depth.frame().depth_m(168, 120) + 0.005;
  ASSERT_TRUE(is_valley);
  EXPECT_EQ(count("convexity"), 2u);
  EXPECT_EQ(count("depth_steps"), 1u);
}

TEST(SegmentCloud, ColorSeparatesFlushBoxesOnlyIfItCounts) {
  TableScene scene;
  scene.AddBox({0.10, 0.06, 0.04}, {0, 0, 0.02});
  RgbdFrame frame = scene.frame();
  frame.color = Image<Rgb8>(frame.depth_m.width(), frame.depth_m.height());
  for (int y = 0; y < frame.color.height(); ++y) {
    for (int x = 0; x < frame.color.width(); ++x) {
      frame.color(x, y) = x < 160 ? Rgb8{200, 40, 40} : Rgb8{40, 40, 200};
    }
  }
  const auto count = [&](const std::string& method) {
    return SegmentFrame(frame, TableScene::Background(), SegmenterNamed(method).options())
        .segments.size();
  };
  EXPECT_EQ(count("convexity_color"), 2u);
  EXPECT_EQ(count("convexity"), 1u);
  frame.color = {};
  EXPECT_EQ(count("convexity_color"), 1u) << "a sensor without color";
}

TEST(SegmentCloud, LabelsAndSegmentsAgree) {
  TableScene scene;
  scene.AddBox({0.06, 0.05, 0.04}, {-0.06, 0, 0.02}, 0.3);
  scene.AddSphere({0.06, 0, 0.03}, 0.03);
  const ObjectSegments found = scene.Segments();
  std::vector<int> pixels(found.segments.size() + 1, 0);
  for (int y = 0; y < found.labels.height(); ++y) {
    for (int x = 0; x < found.labels.width(); ++x) {
      const uint16_t label = found.labels(x, y);
      ASSERT_LE(label, found.segments.size());
      ++pixels[label];
      if (label == 0) continue;
      const ImageBox& box = found.segments[label - 1].box;
      EXPECT_TRUE(x >= box.x && x < box.x + box.width && y >= box.y && y < box.y + box.height);
    }
  }
  for (size_t i = 0; i < found.segments.size(); ++i) {
    EXPECT_EQ(pixels[i + 1], found.segments[i].pixels);
  }
}

TEST(SegmentCloud, AWideImageIsBinnedAndItsLabelsHaveTheFullSize) {
  const CameraIntrinsics k(1224, 1024, 1800, 1800, 611.5, 511.5);
  TableScene scene(k);
  scene.AddBox({0.06, 0.05, 0.04}, {-0.05, 0, 0.02}, 0.3);
  scene.AddBox({0.05, 0.05, 0.03}, {0.05, 0.01, 0.015}, -0.5);
  const ObjectSegments found = scene.Segments();
  EXPECT_EQ(found.segments.size(), 2u);
  EXPECT_EQ(found.labels.width(), 1224);
  EXPECT_EQ(found.labels.height(), 1024);
}

TEST(SegmentCloud, SpecksAndAnEmptyTableGiveNoSegment) {
  TableScene empty;
  EXPECT_TRUE(empty.Segments().segments.empty());
  TableScene speck;
  speck.AddSphere({0, 0, 0.004}, 0.004);  // under 50 px
  EXPECT_TRUE(speck.Segments().segments.empty());
}

TEST(SegmentCloud, APartThatFillsTheImageIsOneSegment) {
  TableScene scene;
  scene.AddBox({1.5, 1.5, 0.05}, {0, 0, 0.025});
  const ObjectSegments found = scene.Segments();
  ASSERT_EQ(found.segments.size(), 1u);
  EXPECT_GT(found.segments.front().pixels, 0.99 * found.labels.size());
}

TEST(SegmentCloud, RefusesAnUnknownMethodAndBadOptions) {
  EXPECT_THAT(ErrorOf([] { SegmenterNamed("convexty"); }), HasSubstr("convexity"));
  SegmenterOptions options;
  options.concave_rad = 0.1;
  EXPECT_THAT(ErrorOf([&] { SegmentCloud({}, options); }), HasSubstr("concave_rad"));
}

TEST(FindPatches, EveryForegroundPixelHasAPatchAndPatchesStayInTheirBlocks) {
  TableScene scene;
  scene.AddBox({0.06, 0.05, 0.04}, {0, 0, 0.02}, 0.3);
  const OrganizedCloud cloud = BuildCloud(scene.frame(), TableScene::Background());
  const SurfacePatches found = FindPatches(cloud);
  const int width = cloud.depth_m.width(), block = PatchOptions().block_px;
  std::vector<std::set<std::pair<int, int>>> blocks(found.patches.size());
  int pixels = 0;
  for (size_t i = 0; i < found.of_pixel.size(); ++i) {
    EXPECT_EQ(found.of_pixel[i] >= 0, cloud.foreground.data()[i] != 0);
    if (found.of_pixel[i] < 0) continue;
    ++pixels;
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    blocks[found.of_pixel[i]].insert({x / block, y / block});
  }
  int sum = 0;
  for (size_t k = 0; k < blocks.size(); ++k) {
    EXPECT_EQ(blocks[k].size(), 1u);
    sum += found.patches[k].pixels;
  }
  EXPECT_EQ(sum, pixels);
  EXPECT_GT(pixels, 1000);
}

// The step is measured across the surface: a steep plane has none.
TEST(FindPatches, ASteepPlaneHasNoSteps) {
  SyntheticDepth depth(SmallCamera());
  depth.AddPlane(Vector3d(0.9, 0, -0.44).normalized(), {0, 0, 0.6});
  CloudOptions options;
  options.min_plane_share = 1;
  const SurfacePatches found = FindPatches(BuildCloud(depth.frame(), std::nullopt, options));
  ASSERT_FALSE(found.borders.empty());
  int steps = 0, all = 0;
  for (const PatchBorder& border : found.borders) {
    steps += border.step_px;
    all += border.step_px + border.smooth_px;
  }
  EXPECT_LT(steps, 0.02 * all);
}

}  // namespace
}  // namespace pickbed::tests
