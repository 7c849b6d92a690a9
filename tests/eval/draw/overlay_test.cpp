#include "eval/draw/overlay.h"

#include <gtest/gtest.h>

#include "eval/draw/canvas.h"
#include "grasp/grippers/table.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

int CountPixels(const Image<Rgb8>& image, const Rgb8& not_this) {
  int count = 0;
  for (const Rgb8& pixel : image.pixels()) count += !(pixel == not_this);
  return count;
}

ObjectSet OpenBoxes() {
  auto model = std::make_shared<ObjectModel>();
  model->mesh_O = BinMesh(Bin{{0.04, 0.04, 0.04}, 0.001, 0.5});
  model->diameter_m = 0.07;
  return {model};
}

constexpr CameraIntrinsics kOverlayCamera{200, 160, 300, 300, 99.5, 79.5};
const OverlayStyle kOnlyLines{.legend = false, .all_labels = false};

OverlayPose PoseAt(const Eigen::Vector3d& center_C, PoseMark mark) {
  return {ObjectId(0), Translation(center_C), 0.5, mark};
}

TEST(ColorizeDepth, HolesAreBlackAndNearDiffersFromFar) {
  Image<float> depth_m(4, 1, 0.f);
  depth_m(1, 0) = 0.5f;
  depth_m(2, 0) = 0.8f;
  depth_m(3, 0) = 1.0f;
  const Image<Rgb8> image = ColorizeDepth(depth_m);
  EXPECT_EQ(image(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_FALSE(image(1, 0) == image(3, 0));
  EXPECT_GT(image(1, 0).r, image(1, 0).b);  // near has a warm color
}

TEST(ColorizeIds, NeighborsDifferInColorAndBackgroundIsBlack) {
  Image<uint16_t> ids(3, 1);
  ids(1, 0) = 1;
  ids(2, 0) = 2;
  const Image<Rgb8> image = ColorizeIds(ids);
  EXPECT_EQ(image(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_FALSE(image(1, 0) == image(2, 0));
}

TEST(DrawOverlay, PoseIsDrawnOnlyWhereItProjects) {
  const Image<Rgb8> picture(200, 160);
  const ObjectSet objects = OpenBoxes();
  const Image<Rgb8> image = DrawOverlay(
      {picture, kOverlayCamera, objects, {PoseAt({0.05, 0, 0.5}, PoseMark::kRight)}}, kOnlyLines);
  EXPECT_GT(CountPixels(image, Rgb8{}), 60);
  // The box is 0.05 / 0.5 * 300 = 30 px right of the center and at most 0.042 m wide.
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 100; ++x) EXPECT_EQ(image(x, y), Rgb8{}) << x << " " << y;
  }
  EXPECT_EQ(DrawOverlay({picture, kOverlayCamera, objects, {}}, kOnlyLines), picture);
}

TEST(DrawOverlay, HiddenPoseDrawsNothing) {
  const Image<Rgb8> picture(200, 160, {90, 90, 90});
  const ObjectSet objects = OpenBoxes();
  const OverlayPose front = PoseAt({0, 0, 0.25}, PoseMark::kRight);
  const OverlayPose behind = PoseAt({0, 0, 0.45}, PoseMark::kWrong);
  const auto drawn = [&](const std::vector<OverlayPose>& poses) {
    return DrawOverlay({picture, kOverlayCamera, objects, poses}, {.legend = false});
  };
  EXPECT_EQ(drawn({front, behind}), drawn({front}));
  EXPECT_EQ(drawn({behind, front}), drawn({front}));
  EXPECT_FALSE(drawn({behind}) == picture);
}

TEST(DrawOverlay, RequestedInstanceIsOutlined) {
  const Image<Rgb8> picture(200, 160, {90, 90, 90});
  Image<uint16_t> ids(200, 160);
  for (int y = 40; y < 80; ++y) {
    for (int x = 60; x < 120; ++x) ids(x, y) = 4;
  }
  const ObjectSet objects = OpenBoxes();
  OverlayInput input{picture, kOverlayCamera, objects, {}};
  input.ids = &ids;
  EXPECT_EQ(DrawOverlay(input, kOnlyLines), picture);
  input.target = InstanceId(3);
  const Image<Rgb8> image = DrawOverlay(input, kOnlyLines);
  EXPECT_GT(std::count(image.pixels().begin(), image.pixels().end(), kTargetColor), 150);
  EXPECT_EQ(image(90, 60), (Rgb8{90, 90, 90}));
}

// The bellows of a cup are soft. Without them the hand would end above the object.
TEST(DrawHand, SoftPartsAreDrawn) {
  const auto cup = LoadGripper("cup_30mm");
  ASSERT_FALSE(cup->SoftBoxes().empty());
  const Eigen::Vector3d soft_G = cup->SoftBoxes().front().center;
  const Image<Rgb8> picture(200, 160, {200, 120, 40});
  Canvas canvas(picture);
  // Approach along x, so that the palm does not hide the lip.
  Pose X_CG = Translation({0, 0, 0.3});
  X_CG.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  DrawHand(canvas, kOverlayCamera, {*cup, X_CG, 0}, 1);
  const Image<Rgb8> image = canvas.Take();
  const Eigen::Vector2d p = Project(kOverlayCamera, X_CG * soft_G);
  EXPECT_FALSE(image(std::lround(p.x()), std::lround(p.y())) == (Rgb8{200, 120, 40}));
}

TEST(OverlayKey, CountsEachKindOfPose) {
  const Image<Rgb8> picture(200, 160);
  const Image<uint16_t> ids(200, 160);
  const ObjectSet objects = OpenBoxes();
  OverlayInput input{picture, kOverlayCamera, objects, {}};
  const auto texts = [&] {
    std::string all;
    for (const KeyEntry& entry : OverlayKey(input)) all += entry.meaning + "\n";
    return all;
  };
  EXPECT_EQ(texts(), "");
  for (const PoseMark mark : {PoseMark::kRight, PoseMark::kWrong, PoseMark::kRight}) {
    input.poses.push_back(PoseAt({0, 0, 0.5}, mark));
  }
  EXPECT_EQ(texts(), "right: 2\nwrong or duplicate: 1\nnumber: score of the pose\n");
  input.poses[1].chosen = true;
  input.ids = &ids;
  input.missed = {InstanceId(1), InstanceId(5)};
  input.target = InstanceId(5);
  EXPECT_EQ(texts(),
            "right: 2\nwrong or duplicate: 1\nnot found: 2\nrequested instance\n"
            "pose of the grasp\nnumber: score of the pose\n");
  input.poses = {PoseAt({0, 0, 0.5}, PoseMark::kUnknown)};
  input.ids = nullptr;
  EXPECT_EQ(texts(), "estimated: 1\nnumber: score of the pose\n");
}

TEST(Canvas, TextStaysWithinItsWidth) {
  constexpr Rgb8 kPaper{250, 250, 250}, kInk{20, 20, 20};
  const std::string long_text = "a name that no tile of this width would hold";
  ASSERT_GT(TextWidth(long_text), 100);
  const auto written = [&](const std::string& text, int width_px) {
    Canvas canvas(400, 30, kPaper);
    canvas.TextWithin(width_px, text, 10, 20, kInk);
    return canvas.Take();
  };
  const Image<Rgb8> image = written(long_text, 100);
  EXPECT_GT(CountPixels(image, kPaper), 100);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 112; x < image.width(); ++x) ASSERT_EQ(image(x, y), kPaper) << x;
  }
  EXPECT_EQ(written("short", 100), written("short", 390));
}

TEST(ContactSheet, ContainsEveryTile) {
  const std::vector<Image<Rgb8>> tiles{Image<Rgb8>(20, 10, {255, 0, 0}),
                                       Image<Rgb8>(20, 10, {0, 255, 0}),
                                       Image<Rgb8>(20, 10, {0, 0, 255})};
  const Image<Rgb8> sheet = ContactSheet(tiles, {"a", "b", "c"}, 2);
  for (const Rgb8 color : {Rgb8{255, 0, 0}, Rgb8{0, 255, 0}, Rgb8{0, 0, 255}}) {
    EXPECT_EQ(std::count(sheet.pixels().begin(), sheet.pixels().end(), color), 200);
  }
}

}  // namespace
}  // namespace pickbed::tests
