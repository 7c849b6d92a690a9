#pragma once

// Common part of the networks and HOG: a crop is described by a row of numbers, and the nearest
// templates are looked up.

#include <functional>

#include "perception/crop_methods/crop_method.h"

namespace pickbed::perception {

// Returns one row of equal length per crop. Uses at most `threads` threads.
using DescribeCrops = std::function<std::vector<float>(const CropSet& crops, int threads)>;

// Makes a method that describes all templates of `training_set` and searches them exactly. `length`
// is the number of values in a row.
std::unique_ptr<CropMethod> MakeCropLookup(std::shared_ptr<const CropTrainingSet> training_set,
                                           DescribeCrops describe, int length, int threads);

}  // namespace pickbed::perception
