#pragma once

// An Image<Rgb8> as an OpenCV matrix, for the drawing functions of this folder.

#include <opencv2/core.hpp>

#include "eval/layer.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// The pixels as a matrix with channels r, g, b; not copied. The matrix must not outlive the image.
inline cv::Mat MatrixOf(Image<Rgb8>& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC3, image.data());
}
// For reading only.
inline cv::Mat MatrixOf(const Image<Rgb8>& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
}

// Converts a color for OpenCV's drawing functions on RGB images.
inline cv::Scalar ToScalar(const Rgb8& color) { return cv::Scalar(color.r, color.g, color.b); }

}  // namespace pickbed::eval
