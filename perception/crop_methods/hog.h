#pragma once

// Histograms of oriented gradients (Dalal and Triggs, CVPR 2005) of the depth and grey images of a
// crop, with OpenCV. The window is 64 x 64 px, a block has 2 x 2 cells of 8 px, and there are 9
// directions: 1,764 values per image. The values of depth come first, then those for grey, as in
// the comparison by Wohlhart and Lepetit.

#include <vector>

#include "perception/crops/crop.h"

namespace pickbed::perception {

inline constexpr int kHogLength = 2 * 1764;

// Returns kHogLength values per crop.
std::vector<float> DescribeByHog(const CropSet& crops, int threads = 1);

}  // namespace pickbed::perception
