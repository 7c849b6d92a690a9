#pragma once

// Methods that describe a crop by a row of numbers and look up the nearest template: what the
// networks and HOG have in common.

#include <functional>

#include "perception/crop_method.h"

namespace pickbed {

// A row of equal length for each crop, by this many threads at most.
using DescribeCrops = std::function<std::vector<float>(const CropSet& crops, int threads)>;

// Describes all templates at once.
std::unique_ptr<CropMethod> MakeCropLookUp(std::shared_ptr<const CropLesson> lesson,
                                           DescribeCrops describe, int length, int threads);

}  // namespace pickbed
