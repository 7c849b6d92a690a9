#include "perception/cloud/color_edges.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

constexpr int kTaps = 5, kReach = kTaps / 2;
using Taps = std::array<float, kTaps>;

// A Gaussian of one pixel. exp() of the standard library may differ in the last bit between CPUs.
Taps Gaussian() {
  constexpr float kAt1 = 0.60653066f, kAt2 = 0.13533528f, kSum = 1 + 2 * (kAt1 + kAt2);
  return {kAt2 / kSum, kAt1 / kSum, 1 / kSum, kAt1 / kSum, kAt2 / kSum};
}

// The derivative of the Gaussian, so that a ramp of one grey level per pixel gives 1.
Taps Derivative(const Taps& gaussian) {
  Taps taps;
  float moment = 0;
  for (int i = 0; i < kTaps; ++i) {
    const auto x = static_cast<float>(i - kReach);
    taps[i] = x * gaussian[i];
    moment += x * taps[i];
  }
  for (float& tap : taps) tap /= moment;
  return taps;
}

// Index of a pixel beyond the border: the image is mirrored at its outermost pixels.
int Mirrored(int index, int size) {
  if (size == 1) return 0;
  while (index < 0 || index >= size) index = index < 0 ? -index : 2 * (size - 1) - index;
  return index;
}

// Filters the rows, then the columns. OpenCV's filter sums in another order on each kind of CPU,
// and this decides between poses.
class SeparableFilter {
 public:
  SeparableFilter(const cv::Mat& brightness, const Taps& along_u, const Taps& along_v)
      : brightness_(brightness), along_u_(along_u), along_v_(along_v) {}

  // Fills the rows `begin` to `end` of the result.
  void Filter(int begin, int end, Image<float>& filtered) const {
    const int width = brightness_.cols, height = brightness_.rows;
    // The filtered rows around the current one, each at its index modulo kTaps.
    Image<float> rows(width, kTaps);
    std::vector<float> line(width + 2 * kReach);
    const auto filter_row = [&](int v) { FilterRow(Mirrored(v, height), line, rows.row(Slot(v))); };
    for (int v = begin - kReach; v < begin + kReach; ++v) filter_row(v);
    for (int v = begin; v < end; ++v) {
      filter_row(v + kReach);
      float* to = filtered.row(v);
      std::fill_n(to, width, 0.f);
      for (int i = 0; i < kTaps; ++i) {
        const float* from = rows.row(Slot(v + i - kReach));
        for (int u = 0; u < width; ++u) to[u] += along_v_[i] * from[u];
      }
    }
  }

 private:
  static int Slot(int v) { return (v + kTaps) % kTaps; }  // v is at least -kReach

  void FilterRow(int v, std::vector<float>& line, float* to) const {
    const int width = brightness_.cols;
    const uint8_t* from = brightness_.ptr<uint8_t>(v);
    for (int u = 0; u < width; ++u) line[u + kReach] = from[u];
    for (int i = 1; i <= kReach; ++i) {
      line[kReach - i] = from[Mirrored(-i, width)];
      line[width - 1 + kReach + i] = from[Mirrored(width - 1 + i, width)];
    }
    for (int u = 0; u < width; ++u) {
      float sum = 0;
      for (int i = 0; i < kTaps; ++i) sum += along_u_[i] * line[u + i];
      to[u] = sum;
    }
  }

  const cv::Mat& brightness_;
  const Taps along_u_, along_v_;
};

}  // namespace

ColorEdges FindColorEdges(const CameraIntrinsics& intrinsics, const Image<Rgb8>& color,
                          int threads) {
  ColorEdges edges{intrinsics, {}, {}};
  if (color.empty()) return edges;
  const cv::Mat rgb(color.height(), color.width(), CV_8UC3,
                    const_cast<Rgb8*>(color.data()));  // only read
  cv::Mat brightness;
  cv::cvtColor(rgb, brightness, cv::COLOR_RGB2GRAY);
  const Taps gaussian = Gaussian(), derivative = Derivative(gaussian);
  edges.du = edges.dv = Image<float>(color.width(), color.height());
  const SeparableFilter along_u(brightness, derivative, gaussian);
  const SeparableFilter along_v(brightness, gaussian, derivative);
  ForRanges(color.height(), threads, [&](int begin, int end) {
    along_u.Filter(begin, end, edges.du);
    along_v.Filter(begin, end, edges.dv);
  });
  return edges;
}

}  // namespace pickbed::perception
