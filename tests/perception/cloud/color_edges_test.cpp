#include "perception/cloud/color_edges.h"

#include <gtest/gtest.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

const CameraIntrinsics kCamera{40, 30, 50, 50, 19.5, 14.5};

TEST(ColorEdges, RampOfBrightnessHasItsSlopeAsGradient) {
  Image<Rgb8> color(40, 30);
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      const auto grey = static_cast<uint8_t>(3 * u + 2 * v);
      color(u, v) = {grey, grey, grey};
    }
  }
  const ColorEdges edges = FindColorEdges(kCamera, color);
  EXPECT_NEAR(edges.du(20, 15), 3, 1e-4);
  EXPECT_NEAR(edges.dv(20, 15), 2, 1e-4);
}

TEST(ColorEdges, StepHasItsLargestGradientAtTheStep) {
  Image<Rgb8> color(40, 30, {50, 50, 50});
  for (int v = 0; v < 30; ++v) {
    for (int u = 20; u < 40; ++u) color(u, v) = {90, 90, 90};
  }
  const ColorEdges edges = FindColorEdges(kCamera, color);
  EXPECT_GT(edges.du(20, 15), 10);
  EXPECT_GT(edges.du(20, 15), edges.du(22, 15));
  EXPECT_NEAR(edges.du(30, 15), 0, 1e-4);
  EXPECT_NEAR(edges.dv(20, 15), 0, 1e-4);
}

// The image continues as its mirror image beyond the border, so that a border is no edge across it.
TEST(ColorEdges, BorderIsNoEdge) {
  Image<Rgb8> color(5, 3);
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < 5; ++u) {
      const auto grey = static_cast<uint8_t>(10 * u * u + 20 * v);
      color(u, v) = {grey, grey, grey};
    }
  }
  const ColorEdges edges = FindColorEdges({5, 3, 50, 50, 2, 1}, color);
  for (int v = 0; v < 3; ++v) {
    EXPECT_NEAR(edges.du(0, v), 0, 1e-4);
    EXPECT_NEAR(edges.du(4, v), 0, 1e-4);
  }
  for (int u = 0; u < 5; ++u) {
    EXPECT_NEAR(edges.dv(u, 0), 0, 1e-4);
    EXPECT_GT(edges.dv(u, 1), 1);
    EXPECT_NEAR(edges.dv(u, 2), 0, 1e-4);
  }
}

TEST(ColorEdges, NoColorGivesNoEdges) { EXPECT_TRUE(FindColorEdges(kCamera, {}).empty()); }

}  // namespace
}  // namespace pickbed::tests
