#include "eval/frames/frame_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "eval/frames/edge_alignment.h"
#include "eval/frames/frame_files.h"
#include "eval/frames/image_estimator.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

const CameraIntrinsics kBlocksCamera(320, 240, 340, 340, 159.5, 119.5);

ObjectSet OneCube(double side_m) {
  auto object = std::make_shared<ObjectModel>();
  object->name = "box";
  object->mesh_O = BoxShape(Eigen::Vector3d::Constant(side_m));
  object->diameter_m = Diameter(object->mesh_O);
  return {object};
}

// Blocks of several sizes, 10 cm above a table at 0.8 m, with the color of their place.
RgbdFrame Blocks(double depth_factor = 1) {
  RgbdFrame frame{kBlocksCamera, Image<Rgb8>(320, 240, {60, 60, 60}),
                  Image<float>(320, 240, static_cast<float>(0.8 * depth_factor))};
  const int blocks[][4] = {
      {60, 50, 50, 40}, {170, 40, 70, 30}, {90, 130, 40, 70}, {200, 120, 60, 60}};
  for (const auto& [left, top, width, height] : blocks) {
    for (int y = top; y < top + height; ++y) {
      for (int x = left; x < left + width; ++x) {
        frame.depth_m(x, y) = static_cast<float>(0.7 * depth_factor);
        frame.color(x, y) = {200, 180, 90};
      }
    }
  }
  return frame;
}

// The color image moved by (dx, dy) and scaled about the principal point.
RgbdFrame WithOtherColor(const RgbdFrame& frame, int dx, int dy, double scale) {
  RgbdFrame other = frame;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const int u =
          static_cast<int>(std::lround((x - dx - kBlocksCamera.cx()) / scale + kBlocksCamera.cx()));
      const int v =
          static_cast<int>(std::lround((y - dy - kBlocksCamera.cy()) / scale + kBlocksCamera.cy()));
      other.color(x, y) = frame.color.Contains(u, v) ? frame.color(u, v) : Rgb8{60, 60, 60};
    }
  }
  return other;
}

std::string FirstError(const RgbdFrame& frame, const ObjectSet& objects, double scale_mm = 1) {
  const std::vector<FrameFinding> findings = CheckFrame(frame, objects, scale_mm);
  return findings.empty() || !findings.front().is_error ? "no error" : findings.front().text;
}

TEST(CheckFrame, PlainFrameHasNoFindings) {
  const std::vector<FrameFinding> findings = CheckFrame(Blocks(), OneCube(0.05), 1);
  for (const FrameFinding& finding : findings) ADD_FAILURE() << finding.text;
}

TEST(CheckFrame, HolesOnlyAreAnError) {
  RgbdFrame frame = Blocks();
  frame.depth_m = Image<float>(320, 240);
  EXPECT_FALSE(HasReadings(frame.depth_m));
  EXPECT_THAT(FirstError(frame, OneCube(0.05)), HasSubstr("no pixel of the depth image"));
  frame.depth_m(1, 1) = 0.8f;
  const auto findings = CheckFrame(frame, OneCube(0.05), 1);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().fault, FrameFault::kFewReadings);
}

TEST(CheckFrame, DepthInAnotherUnitIsSeenByItsRange) {
  EXPECT_THAT(FirstError(Blocks(1e3), OneCube(0.05), 1000), HasSubstr("instead of 1000"));
  EXPECT_THAT(FirstError(Blocks(1e-3), OneCube(0.05), 1), HasSubstr("for example 1000 mm"));
  const auto tenfold = CheckFrame(Blocks(10), OneCube(0.5), 1);
  ASSERT_FALSE(tenfold.empty());
  EXPECT_EQ(tenfold.front().fault, FrameFault::kRange);
  EXPECT_FALSE(tenfold.front().is_error);
  EXPECT_THAT(tenfold.front().text, HasSubstr("0.1"));
}

TEST(CheckFrame, MeshInAnotherUnitIsSeenByItsSizeInTheImage) {
  EXPECT_THAT(FirstError(Blocks(), OneCube(50)), HasSubstr("px wide at 0.8 m"));
  EXPECT_THAT(FirstError(Blocks(), OneCube(0.005)), HasSubstr("check the unit of its mesh"));
  const auto small = CheckFrame(Blocks(), OneCube(0.018), 1);
  ASSERT_FALSE(small.empty());
  EXPECT_FALSE(small.front().is_error);
}

TEST(CheckFrame, PrincipalPointOfAnotherImageIsDoubtful) {
  RgbdFrame frame = Blocks();
  frame.intrinsics = {320, 240, 340, 340, 300, 119.5};
  const auto findings = CheckFrame(frame, OneCube(0.05), 1);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().fault, FrameFault::kPrincipalPoint);
}

TEST(CheckFrame, DepthOfAnotherImageContradictsTheColorEdges) {
  for (const auto& [dx, dy, scale] :
       {std::tuple{16, -8, 1.0}, {0, 0, 1.16}, {-24, 12, 1.0}, {0, 0, 0.87}}) {
    const auto findings = CheckFrame(WithOtherColor(Blocks(), dx, dy, scale), OneCube(0.05), 1);
    ASSERT_EQ(findings.size(), 1u) << dx << " " << scale;
    EXPECT_EQ(findings.front().fault, FrameFault::kEdges);
    const auto found = AlignEdges(WithOtherColor(Blocks(), dx, dy, scale));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->scale, scale, 0.01);
    EXPECT_NEAR(found->shift_px.x(), dx, 4);
    EXPECT_NEAR(found->shift_px.y(), dy, 4);
  }
}

// Color from elsewhere is moved until the frame has no finding.
TEST(RegisterColor, UndoesAShiftButNoScale) {
  RgbdFrame frame = WithOtherColor(Blocks(), 16, -8, 1.0);
  const auto findings = CheckFrame(frame, OneCube(0.05), 1);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NEAR(findings.front().color_move_px.x(), -16, 1);
  EXPECT_NEAR(findings.front().color_move_px.y(), 8, 1);
  EXPECT_THAT(findings.front().text, HasSubstr("the color image is moved"));
  RegisterColor(findings, frame);
  EXPECT_TRUE(CheckFrame(frame, OneCube(0.05), 1).empty());
  const auto scaled = CheckFrame(WithOtherColor(Blocks(), 0, 0, 1.16), OneCube(0.05), 1);
  ASSERT_EQ(scaled.size(), 1u);
  EXPECT_TRUE(scaled.front().color_move_px.isZero());
}

TEST(CheckFrame, AReflectedDepthImageContradictsTheColorEdges) {
  for (const auto& [columns, rows, text] : {std::tuple{true, false, "mirrored left to right"},
                                            {false, true, "mirrored top to bottom"},
                                            {true, true, "turned by 180 degrees"}}) {
    const RgbdFrame frame = Blocks();
    RgbdFrame other = frame;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        other.depth_m(x, y) = frame.depth_m(columns ? 319 - x : x, rows ? 239 - y : y);
      }
    }
    const auto findings = CheckFrame(other, OneCube(0.05), 1);
    ASSERT_EQ(findings.size(), 1u) << text;
    EXPECT_THAT(findings.front().text, HasSubstr(text));
    EXPECT_TRUE(findings.front().color_move_px.isZero());
  }
}

// A symmetric frame fits in both ways. Two scales fit alike, so that none is clear.
TEST(AlignEdges, ASymmetricFrameIsNotReflected) {
  RgbdFrame frame = Blocks();
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double radius = std::hypot((x - 159.5) / 100, (y - 119.5) / 70);
      const bool is_ring = radius < 1 && radius > 0.87;
      frame.color(x, y) = is_ring ? Rgb8{200, 180, 90} : Rgb8{60, 60, 60};
      frame.depth_m(x, y) = radius < 1 ? 0.7f : 0.8f;
    }
  }
  EXPECT_FALSE(AlignEdges(frame));
  EXPECT_TRUE(CheckFrame(frame, OneCube(0.05), 1).empty());
}

TEST(AlignEdges, SaysNothingWithoutEdges) {
  RgbdFrame frame = Blocks();
  frame.color = {};
  EXPECT_FALSE(AlignEdges(frame));
  frame = Blocks();
  for (int level = 0; level < 256; level += 15) {
    const auto grey = static_cast<uint8_t>(level);
    frame.color = Image<Rgb8>(320, 240, {grey, grey, grey});
    EXPECT_FALSE(AlignEdges(frame)) << level;
  }
  frame = Blocks();
  frame.depth_m = Image<float>(320, 240, 0.8f);
  EXPECT_FALSE(AlignEdges(frame));
}

TEST(AlignEdges, RealFramesFitWhereTheyAre) {
  const std::filesystem::path data = PICKBED_TEST_DATA;
  int measured = 0;  // planted faults that were found
  for (const char* frame : {"bop_icbin_mini/test/000001", "bop_icbin_mini/test/000005",
                            "bop_icbin_mini/test/000007", "bop_ycbv_mini/test/000001"}) {
    const std::filesystem::path scene = data / frame;
    if (!std::filesystem::exists(scene)) GTEST_SKIP() << scene << " is absent";
    const std::string camera = (scene.parent_path().parent_path() / "camera.json").string();
    int images = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scene / "rgb")) {
      ++images;
      const FrameOfFiles read =
          ReadFrameFiles({entry.path(), scene / "depth" / entry.path().filename(), camera, 0});
      for (const FrameFinding& finding :
           CheckFrame(read.frame, OneCube(0.08), read.depth_scale_mm)) {
        ADD_FAILURE() << frame << ": " << finding.text;
      }
      // Planted faults: color that is farther to the right, and reflected depth.
      for (const int shift_px : {8, 20, 32}) {
        RgbdFrame moved = read.frame;
        for (int y = 0; y < moved.color.height(); ++y) {
          for (int x = shift_px; x < moved.color.width(); ++x) {
            moved.color(x, y) = read.frame.color(x - shift_px, y);
          }
        }
        const auto found = AlignEdges(moved);
        if (!found) continue;
        ++measured;
        EXPECT_LT(found->fit_here, 0.9) << frame;
        EXPECT_EQ(found->scale, 1) << frame;
        EXPECT_EQ(found->flip, DepthFlip::kNone) << frame;
        EXPECT_NEAR(found->shift_px.x(), shift_px, 3) << frame;
        EXPECT_NEAR(found->shift_px.y(), 0, 3) << frame;
      }
      RgbdFrame mirrored = read.frame;
      for (int y = 0; y < mirrored.depth_m.height(); ++y) {
        float* row = mirrored.depth_m.row(y);
        std::reverse(row, row + mirrored.depth_m.width());
      }
      const auto found = AlignEdges(mirrored);
      if (!found) continue;
      ++measured;
      EXPECT_EQ(found->flip, DepthFlip::kColumns) << frame;
    }
    EXPECT_GT(images, 0) << frame;
  }
  // The frame of ycbv shows few objects, so nothing can be said of it.
  EXPECT_EQ(measured, 3 * 4);
}

}  // namespace
}  // namespace pickbed::tests
