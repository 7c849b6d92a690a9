// Completion of degenerate views: the volume is finite, or the view is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/completion/completed_volume.h"
#include "perception/completion/completion_input.h"
#include "perception/completion/shape_completer.h"
#include "perception/completion/traced_solid.h"
#include "scenes/base/error.h"
#include "tests/support/degenerate_depth.h"

namespace pickbed::tests {
namespace {

// The segment is a square in the middle of the image.
SegmentView ViewOf(const DepthCase& test, int half_px = 20) {
  const RgbdFrame frame = FrameOf(test);
  SegmentView view;
  view.intrinsics = frame.intrinsics;
  view.depth_m = frame.depth_m;
  view.segment = Image<uint8_t>(frame.depth_m.width(), frame.depth_m.height(), 0);
  for (int y = 120 - half_px; y < 120 + half_px; ++y) {
    for (int x = 160 - half_px; x < 160 + half_px; ++x) view.segment(x, y) = 1;
  }
  return view;
}

bool IsProbability(float p) { return p >= 0 && p <= 1; }

void ExpectSound(const CompletedVolume& volume, const std::string& name) {
  if (volume.empty()) return;
  EXPECT_TRUE(volume.origin_C.allFinite()) << name;
  EXPECT_TRUE(std::isfinite(volume.cell_m) && volume.cell_m > 0) << name;
  EXPECT_TRUE(std::all_of(volume.occupancy.begin(), volume.occupancy.end(), IsProbability)) << name;
  const Eigen::Vector3f center_C = volume.Center_C(volume.size / 2, volume.size / 2, 1);
  EXPECT_TRUE(IsProbability(volume.At(center_C))) << name;
  EXPECT_TRUE(volume.Gradient(center_C).allFinite()) << name;
}

// The methods without a network. The network gets the same input, see below.
TEST(DegenerateViews, EveryRuleGivesProbabilitiesOrRefuses) {
  for (const CompleterRow& row : CompleterTable()) {
    if (row.kind != nullptr || row.name == "nearest_shape") continue;
    CompletionOptions options;
    options.method = row.name;
    options.cells = 16;
    const std::unique_ptr<ShapeCompleter> completer = MakeCompleter(options);
    for (const DepthCase& test : DepthCases()) {
      const std::string name = row.name + ", " + test.name;
      for (const bool has_floor : {false, true}) {
        SegmentView view = ViewOf(test);
        if (has_floor) view.floor = FloorPlane{.offset_m = -0.9f};
        try {
          ExpectSound(completer->Complete(view), name);
        } catch (const InputError&) {
          EXPECT_LT(SegmentPixels(view), kMinSegmentPixels) << name;
          EXPECT_TRUE(completer->CompleteAll({{view}}).front().empty()) << name;
        }
      }
    }
  }
}

TEST(DegenerateViews, TheInputOfTheNetworkIsFinite) {
  for (const DepthCase& test : DepthCases()) {
    const SegmentView view = ViewOf(test);
    if (SegmentPixels(view) < kMinSegmentPixels) {
      EXPECT_THROW(CheckSegmentView(view), InputError) << test.name;
      continue;
    }
    const CompletionInput input(view);
    const CompletionCube& cube = input.cube();
    EXPECT_TRUE(cube.origin_C.allFinite()) << test.name;
    EXPECT_TRUE(std::isfinite(cube.side_m) && cube.side_m > 0) << test.name;
    for (const float share : {-0.5f, 0.0f, 0.3f, 0.5f, 1.0f, 2.0f}) {
      const Eigen::Vector3f p_C = cube.origin_C.array() + share * cube.side_m;
      for (const float fact : input.Facts(p_C)) EXPECT_TRUE(std::isfinite(fact)) << test.name;
    }
    EXPECT_FALSE(input.Channels().empty());
  }
}

// Bad readings are no readings: the others of the segment count.
TEST(DegenerateViews, ReadingsThatAreNotFiniteAreLeftOut) {
  for (const DepthCase& test : DepthCases()) {
    if (test.not_finite == 0) continue;
    const int readings = test.not_finite == kDegeneratePixels ? 0 : 800;
    EXPECT_EQ(SegmentPixels(ViewOf(test)), readings) << test.name;
  }
}

TEST(DegenerateVolumes, ValuesAndGradientsAreZeroOutside) {
  CompletedVolume one;
  one.cell_m = 0.01f;
  one.size = 1;
  one.occupancy = {1};
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const CompletedVolume& volume : {CompletedVolume(), one, Smoothed(one, 1)}) {
    for (const float far : {-1.0f, 1.0f, 1e30f, kNaN, std::numeric_limits<float>::infinity()}) {
      EXPECT_EQ(volume.At({far, 0, 0}), 0) << far;
    }
    EXPECT_TRUE(volume.Gradient({0.005f, 0.005f, 0.005f}).allFinite());
  }
  EXPECT_EQ(one.At({0.005f, 0.005f, 0.005f}), 1);
}

// A solid without matter, and one around the camera.
TEST(DegenerateSolids, DepthIsZeroOrFinite) {
  const CameraIntrinsics k = SmallCamera();
  const Eigen::AlignedBox3f box(Eigen::Vector3f::Constant(-0.1f), Eigen::Vector3f::Constant(0.1f));
  for (const float distance_m : {1.0f, -1.0f, 0.0f}) {
    const TracedSolid solid(
        [&](std::span<const Eigen::Vector3f>, std::span<float> distances_m) {
          std::fill(distances_m.begin(), distances_m.end(), distance_m);
        },
        box);
    for (const double z_m : {0.5, 0.0, -0.5}) {
      const Image<float> depth = solid.Depth(k, Translation({0, 0, z_m}));
      for (const float d : depth.pixels()) ASSERT_TRUE(std::isfinite(d) && d >= 0) << distance_m;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
