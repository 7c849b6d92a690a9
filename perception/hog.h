#pragma once

// Histograms of oriented gradients (Dalal and Triggs, CVPR 2005) of a crop's depth and grey by
// OpenCV: one window of 64 x 64 px, blocks of 2 x 2 cells of 8 px, 9 directions, so 1,764 values
// for each image. Depth and grey stand one after the other, as in Wohlhart and Lepetit's
// comparison.

#include <vector>

#include "perception/crop.h"

namespace pickbed {

inline constexpr int kHogLength = 2 * 1764;

std::vector<float> DescribeByHog(const CropSet& crops, int threads = 1);

}  // namespace pickbed
