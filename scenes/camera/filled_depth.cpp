#include "scenes/camera/filled_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pickbed::scenes {
namespace {

// Fills the gaps of one line of pixels with the nearer of the two readings at their ends. Where the
// line meets the border of the image, the other end counts.
void FillGaps(const Image<float>& depth_m, int begin, int step, int count, Image<float>& filled) {
  const float* from = depth_m.data() + begin;
  float* to = filled.data() + begin;
  for (int i = 0; i < count;) {
    if (IsReading(from[static_cast<ptrdiff_t>(i) * step])) {
      ++i;
      continue;
    }
    int end = i;
    while (end < count && !IsReading(from[static_cast<ptrdiff_t>(end) * step])) ++end;
    float nearest_m = std::numeric_limits<float>::infinity();
    if (i > 0) nearest_m = std::min(nearest_m, from[static_cast<ptrdiff_t>(i - 1) * step]);
    if (end < count) nearest_m = std::min(nearest_m, from[static_cast<ptrdiff_t>(end) * step]);
    for (; i < end; ++i) {
      float& value = to[static_cast<ptrdiff_t>(i) * step];
      value = std::min(value, nearest_m);
    }
  }
}

}  // namespace

bool IsReading(float depth_m) { return depth_m > 0 && std::isfinite(depth_m); }

Image<float> FilledDepth(const Image<float>& depth_m) {
  const int width = depth_m.width(), height = depth_m.height();
  Image<float> filled(width, height, std::numeric_limits<float>::infinity());
  for (int y = 0; y < height; ++y) FillGaps(depth_m, y * width, 1, width, filled);
  for (int x = 0; x < width; ++x) FillGaps(depth_m, x, width, height, filled);
  for (size_t i = 0; i < depth_m.size(); ++i) {
    if (IsReading(depth_m.data()[i])) filled.data()[i] = depth_m.data()[i];
  }
  return filled;
}

}  // namespace pickbed::scenes
