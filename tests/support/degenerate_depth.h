#pragma once

// Depth images that break the usual assumptions, for the tests of all stages that measure geometry.

#include <functional>
#include <limits>
#include <vector>

#include "scenes/camera/camera.h"
#include "tests/support/layer.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {

// A depth image and the number of its readings that are not finite.
struct DepthCase {
  const char* name;
  std::function<float(int x, int y)> depth_m;
  int not_finite = 0;
};

inline constexpr int kDegeneratePixels = 320 * 240;

inline std::vector<DepthCase> DepthCases() {
  return {{"no reading", [](int, int) { return 0.0f; }},
          {"one reading", [](int x, int y) { return x == 160 && y == 120 ? 0.8f : 0.0f; }},
          {"a row", [](int, int y) { return y == 120 ? 0.8f : 0.0f; }},
          {"a column", [](int x, int) { return x == 160 ? 0.8f : 0.0f; }},
          {"constant depth", [](int, int) { return 0.8f; }},
          {"a slanted plane", [](int x, int) { return 0.8f / (1 + 0.001f * (x - 160)); }},
          {"single points", [](int x, int y) { return x % 4 == 0 && y % 4 == 0 ? 0.8f : 0.0f; }},
          {"not a number", [](int, int) { return std::numeric_limits<float>::quiet_NaN(); },
           kDegeneratePixels},
          {"infinite", [](int, int) { return std::numeric_limits<float>::infinity(); },
           kDegeneratePixels},
          {"some infinite",
           [](int x, int) { return x % 2 == 0 ? std::numeric_limits<float>::infinity() : 0.8f; },
           kDegeneratePixels / 2},
          {"some not a number",
           [](int x, int) { return x % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.8f; },
           kDegeneratePixels / 2},
          {"negative", [](int, int) { return -0.8f; }},
          {"tiny", [](int, int) { return 1e-30f; }},
          {"denormal", [](int, int) { return 1e-42f; }},
          {"huge", [](int, int) { return 1e30f; }},
          {"the largest number", [](int, int) { return std::numeric_limits<float>::max(); }},
          {"steps of many metres", [](int x, int y) { return (x + y) % 2 ? 0.5f : 5000.0f; }}};
}

inline RgbdFrame FrameOf(const DepthCase& test) {
  RgbdFrame frame;
  frame.intrinsics = SmallCamera();
  frame.depth_m = Image<float>(frame.intrinsics.width(), frame.intrinsics.height());
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) frame.depth_m(x, y) = test.depth_m(x, y);
  }
  return frame;
}

}  // namespace pickbed::tests
