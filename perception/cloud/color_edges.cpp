#include "perception/cloud/color_edges.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

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
Image<float> Filtered(const cv::Mat& brightness, const Taps& along_u, const Taps& along_v) {
  const int width = brightness.cols, height = brightness.rows;
  Image<float> rows(width, height), filtered(width, height);
  std::vector<float> line(width + 2 * kReach);
  for (int v = 0; v < height; ++v) {
    const uint8_t* from = brightness.ptr<uint8_t>(v);
    for (int u = -kReach; u < width + kReach; ++u) line[u + kReach] = from[Mirrored(u, width)];
    float* to = rows.row(v);
    for (int u = 0; u < width; ++u) {
      float sum = 0;
      for (int i = 0; i < kTaps; ++i) sum += along_u[i] * line[u + i];
      to[u] = sum;
    }
  }
  for (int v = 0; v < height; ++v) {
    float* to = filtered.row(v);
    std::fill_n(to, width, 0.f);
    for (int i = 0; i < kTaps; ++i) {
      const float* from = rows.row(Mirrored(v + i - kReach, height));
      for (int u = 0; u < width; ++u) to[u] += along_v[i] * from[u];
    }
  }
  return filtered;
}

}  // namespace

ColorEdges FindColorEdges(const CameraIntrinsics& intrinsics, const Image<Rgb8>& color) {
  ColorEdges edges{intrinsics, {}, {}};
  if (color.empty()) return edges;
  const cv::Mat rgb(color.height(), color.width(), CV_8UC3,
                    const_cast<Rgb8*>(color.data()));  // only read
  cv::Mat brightness;
  cv::cvtColor(rgb, brightness, cv::COLOR_RGB2GRAY);
  const Taps gaussian = Gaussian(), derivative = Derivative(gaussian);
  edges.du = Filtered(brightness, derivative, gaussian);
  edges.dv = Filtered(brightness, gaussian, derivative);
  return edges;
}

}  // namespace pickbed::perception
