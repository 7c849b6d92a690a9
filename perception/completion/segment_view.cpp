#include "perception/completion/segment_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Returns the smallest box around the segment, grown by its larger side and cut to the image.
ImageBox Surroundings(const SegmentView& view) {
  const int width = view.segment.width(), height = view.segment.height();
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!view.segment(x, y) || !HasReading(view.depth_m(x, y))) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return {};
  const int margin = std::max(right - left, bottom - top) + 1;
  left = std::max(left - margin, 0);
  top = std::max(top - margin, 0);
  right = std::min(right + margin, width - 1);
  bottom = std::min(bottom + margin, height - 1);
  return {left, top, right - left + 1, bottom - top + 1};
}

// Depth of the nearest segment pixel for each pixel of a box. Two passes over the image spread the
// position of the nearest pixel (Danielsson 1980).
class NearestDepth {
 public:
  NearestDepth(const SegmentView& view, const ImageBox& box)
      : box_(box), nearest_(box.width, box.height, kNone) {
    for (int y = 0; y < box.height; ++y) {
      for (int x = 0; x < box.width; ++x) {
        if (view.segment(box.x + x, box.y + y) && HasReading(view.depth_m(box.x + x, box.y + y))) {
          nearest_(x, y) = {x, y};
        }
      }
    }
    for (int y = 0; y < box.height; ++y) {
      for (int x = 0; x < box.width; ++x) {
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) {
          Offer(x, y, x + dx, y + dy);
        }
      }
      for (int x = box.width - 1; x >= 0; --x) Offer(x, y, x + 1, y);
    }
    for (int y = box.height - 1; y >= 0; --y) {
      for (int x = box.width - 1; x >= 0; --x) {
        for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) {
          Offer(x, y, x + dx, y + dy);
        }
      }
      for (int x = 0; x < box.width; ++x) Offer(x, y, x - 1, y);
    }
  }

  float At(const SegmentView& view, int x, int y) const {
    const Place place = nearest_(x, y);
    return view.depth_m(box_.x + place.x, box_.y + place.y);
  }

 private:
  struct Place {
    int x, y;
  };
  static constexpr Place kNone{-1, -1};

  static int64_t Squared(const Place& place, int x, int y) {
    if (place.x < 0) return INT64_MAX;
    const int64_t dx = place.x - x, dy = place.y - y;
    return dx * dx + dy * dy;
  }
  void Offer(int x, int y, int from_x, int from_y) {
    if (!nearest_.Contains(from_x, from_y)) return;
    const Place offered = nearest_(from_x, from_y);
    if (Squared(offered, x, y) < Squared(nearest_(x, y), x, y)) nearest_(x, y) = offered;
  }

  ImageBox box_;
  Image<Place> nearest_;
};

}  // namespace

Image<uint8_t> MarkOccluders(const SegmentView& view, float step_m) {
  Image<uint8_t> occluders(view.depth_m.width(), view.depth_m.height(), 0);
  const ImageBox box = Surroundings(view);
  if (box.width == 0) return occluders;
  const NearestDepth nearest(view, box);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const int column = box.x + x, row = box.y + y;
      const float depth_m = view.depth_m(column, row);
      if (view.segment(column, row) || !HasReading(depth_m)) continue;
      occluders(column, row) = depth_m < nearest.At(view, x, y) - step_m;
    }
  }
  return occluders;
}

int SegmentPixels(const SegmentView& view) {
  int count = 0;
  for (size_t i = 0; i < view.segment.size() && i < view.depth_m.size(); ++i) {
    count += view.segment.pixels()[i] != 0 && HasReading(view.depth_m.pixels()[i]);
  }
  return count;
}

void CheckSegmentView(const SegmentView& view) {
  const int width = view.intrinsics.width(), height = view.intrinsics.height();
  const auto check = [&](const auto& image, const char* name) {
    CheckInput(image.width() == width && image.height() == height,
               fmt::format("the {} has {} x {} px, but the camera has {} x {} px", name,
                           image.width(), image.height(), width, height));
  };
  check(view.depth_m, "depth image");
  check(view.segment, "segment");
  if (!view.occluders.empty()) check(view.occluders, "image of the occluders");
  const int count = SegmentPixels(view);
  CheckInput(count >= kMinSegmentPixels,
             fmt::format("the segment has {} pixels with depth; a completion needs at least {}",
                         count, kMinSegmentPixels));
}

}  // namespace pickbed::perception
