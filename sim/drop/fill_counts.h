#pragma once

// Number of instances that fill a bin to a wanted level.

#include <vector>

#include "scenes/scene.h"
#include "sim/drop/drop.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Returns the number of instances of each object with which the surface of the settled pile is, on
// average, at `fill` times the inner height of the bin.
// - shares: relative number of instances of each object, > 0
// - fill: wanted fill level (see FillStatistics), 0..1
// The counts come from drops with own random streams, so they depend only on the arguments. They
// are cached on disk. Throws InputError if the bin has no height or the level cannot be reached.
std::vector<int> CountsForFill(const Bin& bin, const ObjectSet& objects,
                               const std::vector<int>& shares, double fill,
                               const DropOptions& options = {});

}  // namespace pickbed::sim
