#include "perception/crop_methods/hog.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "scenes/base/parallel.h"

namespace pickbed::perception {

std::vector<float> DescribeByHog(const CropSet& crops, int threads) {
  std::vector<float> rows(crops.size() * kHogLength);
  cv::setNumThreads(1);
  const cv::HOGDescriptor hog({kCropPixels, kCropPixels}, {16, 16}, {8, 8}, {8, 8}, 9);
  ForRanges(static_cast<int>(crops.size()), threads, [&](int begin, int end) {
    cv::Mat depth(kCropPixels, kCropPixels, CV_8U), color(kCropPixels, kCropPixels, CV_8UC3), grey;
    std::vector<float> values;
    for (int i = begin; i < end; ++i) {
      const auto of_depth = crops.depth_of(i);
      for (int p = 0; p < kCropArea; ++p) {
        depth.data[p] = static_cast<uint8_t>(127.5 * (1 + of_depth[p] / kCropDepthUnit));
      }
      std::copy_n(reinterpret_cast<const uint8_t*>(crops.color_of(i).data()), 3 * kCropArea,
                  color.data);
      cv::cvtColor(color, grey, cv::COLOR_RGB2GRAY);
      float* next = rows.data() + static_cast<size_t>(i) * kHogLength;
      for (const cv::Mat* image : {&depth, &grey}) {
        hog.compute(*image, values);
        next = std::copy(values.begin(), values.end(), next);
      }
    }
  });
  return rows;
}

}  // namespace pickbed::perception
