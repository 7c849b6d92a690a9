#include "perception/completion/segment_window.h"

#include <algorithm>
#include <cmath>

namespace pickbed::perception {

SegmentView SegmentWindow(const Image<float>& depth_m, const CameraIntrinsics& intrinsics,
                          const Image<uint16_t>& labels, const ObjectSegment& segment, int label,
                          double margin) {
  const ImageBox& box = segment.box;
  const int border = static_cast<int>(std::ceil(margin * std::max(box.width, box.height)));
  const int x0 = std::max(0, box.x - border), y0 = std::max(0, box.y - border);
  const int x1 = std::min(depth_m.width(), box.x + box.width + border);
  const int y1 = std::min(depth_m.height(), box.y + box.height + border);
  SegmentView view;
  view.intrinsics = intrinsics.Window(x0, y0, x1 - x0, y1 - y0);
  view.depth_m = Image<float>(x1 - x0, y1 - y0);
  view.segment = Image<uint8_t>(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      view.depth_m(x - x0, y - y0) = depth_m(x, y);
      view.segment(x - x0, y - y0) = labels(x, y) == label;
    }
  }
  return view;
}

}  // namespace pickbed::perception
