#pragma once

// Pixels in which candidates are searched.
//
// Without a known background, walls, shelves and large boxes are foreground, and most of the search
// would be for poses on them. A smooth surface that is larger than an object does not belong to it.
// But equal faces of several objects side by side may look like one surface, so these pixels are
// searched, too, only more sparsely.

#include <vector>

#include "perception/cloud/organized_cloud.h"

namespace pickbed::perception {

// One pixel in so many is searched on a surface that is larger than the objects.
inline constexpr int kLargeSurfaceStride = 6;

// Returns the foreground pixels of the cloud in ascending order. Unless the background is given, a
// smooth surface with a larger extent than the objects contributes one pixel in
// kLargeSurfaceStride.
// - diameter_m: of the largest object
std::vector<int> SearchPixels(const OrganizedCloud& cloud, double diameter_m);

}  // namespace pickbed::perception
