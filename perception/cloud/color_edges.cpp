#include "perception/cloud/color_edges.h"

#include <opencv2/imgproc.hpp>

namespace pickbed::perception {

ColorEdges FindColorEdges(const CameraIntrinsics& intrinsics, const Image<Rgb8>& color) {
  ColorEdges edges{intrinsics, {}, {}};
  if (color.empty()) return edges;
  const cv::Mat rgb(color.height(), color.width(), CV_8UC3,
                    const_cast<Rgb8*>(color.data()));  // only read
  cv::Mat brightness;
  cv::cvtColor(rgb, brightness, cv::COLOR_RGB2GRAY);
  constexpr int kTaps = 5;
  const cv::Mat gaussian = cv::getGaussianKernel(kTaps, 1.0, CV_32F);
  cv::Mat derivative(kTaps, 1, CV_32F);
  // The derivative of the Gaussian, so that a ramp of one grey level per pixel gives 1.
  float moment = 0;
  for (int i = 0; i < kTaps; ++i) {
    const float x = static_cast<float>(i - kTaps / 2);
    derivative.at<float>(i) = x * gaussian.at<float>(i);
    moment += x * derivative.at<float>(i);
  }
  derivative /= moment;
  const auto filter = [&](const cv::Mat& along_u, const cv::Mat& along_v) {
    Image<float> filtered(color.width(), color.height());
    cv::Mat to(color.height(), color.width(), CV_32F, filtered.data());
    cv::sepFilter2D(brightness, to, CV_32F, along_u, along_v);
    return filtered;
  };
  edges.du = filter(derivative, gaussian);
  edges.dv = filter(gaussian, derivative);
  return edges;
}

}  // namespace pickbed::perception
