#pragma once

// How full a bin is and which of its instances cover others.

#include <vector>

#include "scenes/scene.h"
#include "sim/layer.h"

namespace pickbed::sim {

// The pile of a scene, seen from straight above in cells of a grid on the bin floor.
struct FillStatistics {
  // Mean height of the pile's surface over the inner height of the bin, 0 for an empty bin. The
  // floor counts where no instance is. For a table, whose height is 0, it is 0.
  double fill_level = 0;
  // Layer of scene.objects[i], 1 = top. The instances with at least half of their top view
  // uncovered are layer 1. Layer 2 is layer 1 of the pile without them, and so on.
  std::vector<int> layers;
  // Number of instances that cover some of scene.objects[i], and number that it covers, in the top
  // view. If two instances share cells, the one that is higher in more of them covers the other;
  // with equal numbers, neither does.
  std::vector<int> above, below;
};

// Measures the pile on the actual meshes. Throws std::logic_error if an object index is invalid.
FillStatistics MeasureFill(const Scene& scene, const ObjectSet& objects);

}  // namespace pickbed::sim
