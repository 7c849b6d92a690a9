#include "eval/frames/region.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/cloud/organized_cloud.h"
#include "scenes/image/image_io.h"
#include "tests/scenes/shapes.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

ObjectSet OneBox(double side_m) {
  auto object = std::make_shared<ObjectModel>();
  object->name = "box";
  object->mesh_O = BoxShape(Eigen::Vector3d::Constant(side_m));
  object->diameter_m = Diameter(object->mesh_O);
  return {object};
}

// Two boxes on a table that fills the image.
RgbdFrame TwoBoxes() {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane(-Eigen::Vector3d::UnitZ(), {0, 0, 0.8});
  for (const double x : {-0.1, 0.1}) {
    scene.AddMesh(BoxShape({0.06, 0.06, 0.06}), Translation(Eigen::Vector3d(x, 0, 0.77)));
  }
  return scene.frame();
}

PoseHypothesis At(const Eigen::Vector3d& p_C) {
  PoseHypothesis pose;
  pose.X_CO = Translation(p_C);
  return pose;
}

TEST(ImageRegion, BoxOfTheWorldHoldsItsPixelsAndPoses) {
  const RgbdFrame frame = TwoBoxes();
  const ObjectSet objects = OneBox(0.06);
  // The world is moved by 0.5 m against the camera.
  const Pose X_CW = Translation(Eigen::Vector3d(0, 0, 0.5));
  const RegionSpec spec = ParseRegion("world:-0.2,-0.2,0.2,0,0.2,0.32");
  const ImageRegion region = MakeRegion(spec, frame, X_CW, objects);
  const Eigen::Vector2d left = Project(frame.intrinsics, {-0.1, 0, 0.74}),
                        right = Project(frame.intrinsics, {0.1, 0, 0.74});
  EXPECT_EQ(region.pixels(static_cast<int>(left.x()), static_cast<int>(left.y())), 1);
  EXPECT_EQ(region.pixels(static_cast<int>(right.x()), static_cast<int>(right.y())), 0);
  EXPECT_EQ(region.BoxLines(frame.intrinsics).size(), 12u);
  std::vector<PoseHypothesis> poses{At({-0.1, 0, 0.77}), At({0.1, 0, 0.77})};
  KeepPosesIn(region, frame.intrinsics, objects, poses);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].X_CO.translation().x(), -0.1);
  EXPECT_THAT(ErrorOf([&] { MakeRegion(spec, frame, std::nullopt, objects); }),
              HasSubstr("pose of the camera is not known"));
}

TEST(ImageRegion, MaskHoldsPosesThatAreMostlySeenInIt) {
  const RgbdFrame frame = TwoBoxes();
  const ObjectSet objects = OneBox(0.06);
  const TemporaryFolder folder;
  Image<Rgb8> mask(frame.depth_m.width(), frame.depth_m.height());
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = mask.width() / 2; x < mask.width(); ++x) mask(x, y) = {255, 255, 255};
  }
  RegionSpec spec;
  spec.mask = (folder.path() / "mask.png").string();
  WritePng(spec.mask, mask);
  const ImageRegion region = MakeRegion(spec, frame, std::nullopt, objects);
  std::vector<PoseHypothesis> poses{At({-0.1, 0, 0.77}), At({0.1, 0, 0.77})};
  KeepPosesIn(region, frame.intrinsics, objects, poses);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].X_CO.translation().x(), 0.1);
  WritePng(spec.mask, Image<Rgb8>(3, 2));
  EXPECT_THAT(ErrorOf([&] { MakeRegion(spec, frame, std::nullopt, objects); }),
              HasSubstr("the mask is 3x2 px"));
}

TEST(ImageRegion, AutomaticRegionEndsWhereTheLargestObjectIsTooSmall) {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane(-Eigen::Vector3d::UnitZ(), {0, 0, 6});
  scene.AddMesh(BoxShape({0.1, 0.1, 0.1}), Translation(Eigen::Vector3d(0, 0, 0.6)));
  const RgbdFrame& frame = scene.frame();
  RegionSpec spec;
  spec.automatic = true;
  const ImageRegion region = MakeRegion(spec, frame, std::nullopt, OneBox(0.1));
  const CameraIntrinsics& k = frame.intrinsics;
  EXPECT_EQ(region.pixels(k.width() / 2, k.height() / 2), 1);
  EXPECT_EQ(region.pixels(1, 1), 0) << "the wall at 6 m is in the region";
  EXPECT_TRUE(region.BoxLines(k).empty());
}

// Only the region is foreground. The depth outside stays, because it can contradict poses.
TEST(ImageRegion, CloudSearchesOnlyInTheRegion) {
  const RgbdFrame frame = TwoBoxes();
  const ImageRegion region =
      MakeRegion(ParseRegion("camera:-0.2,-0.2,0.7,0,0.2,0.9"), frame, std::nullopt, OneBox(0.06));
  const perception::OrganizedCloud all = perception::BuildCloud(frame, std::nullopt);
  const perception::OrganizedCloud some =
      perception::BuildCloud(frame, std::nullopt, {}, &region.pixels);
  EXPECT_GT(some.foreground_pixels.size(), 0u);
  EXPECT_NEAR(2.0 * some.foreground_pixels.size(), all.foreground_pixels.size(),
              0.2 * all.foreground_pixels.size());
  for (const int pixel : some.foreground_pixels) EXPECT_NE(region.pixels.data()[pixel], 0);
  EXPECT_GT(some.depth_m(some.depth_m.width() - 2, 2), 0);
  EXPECT_FALSE(some.planes.empty());
}

TEST(ImageRegion, PictureOfAWindowShowsTheSamePlaces) {
  const RgbdFrame frame = TwoBoxes();
  const ImageRegion region =
      MakeRegion(ParseRegion("camera:-0.2,-0.2,0.7,0,0.2,0.9"), frame, std::nullopt, OneBox(0.06));
  const CameraIntrinsics window = frame.intrinsics.Window(10, 5, 40, 30);
  const Image<uint8_t> pixels = RegionInPicture(region, frame.intrinsics, window);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) ASSERT_EQ(pixels(x, y), region.pixels(x + 10, y + 5));
  }
}

TEST(ImageRegion, WithoutAReadingIsRefusedWithTheRangeOfTheReadings) {
  const RgbdFrame frame = TwoBoxes();
  const auto error = [&](const std::string& text) {
    return ErrorOf([&] {
      RequireReadingsIn(MakeRegion(ParseRegion(text), frame, std::nullopt, OneBox(0.06)), frame,
                        text);
    });
  };
  EXPECT_EQ(error("camera:5,5,5,6,6,6"),
            "region 'camera:5,5,5,6,6,6': no depth reading of the image is in it; readings are "
            "from 0.74 to 0.8 m");
  EXPECT_NO_THROW(RequireReadingsIn(
      MakeRegion(ParseRegion("camera:-9,-9,0.7,9,9,0.9"), frame, std::nullopt, OneBox(0.06)), frame,
      "table"));
}

}  // namespace
}  // namespace pickbed::tests
