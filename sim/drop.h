#pragma once

// Pours parts into a bin in layers and lets them come to rest.

#include <string>
#include <vector>

#include "scenes/random.h"
#include "scenes/scene.h"
#include "sim/physics_world.h"

namespace pickbed {

struct DropOptions {
  double layer_interval_s = 0.15;
  double max_s = 8;  // simulated; the loop is bounded by it
  PhysicsOptions physics;
};

struct DropReport {
  bool at_rest = false;  // else timed out
  double simulated_s = 0;
  int left_bin = 0;          // parts that ended outside the bin: counted, and not in the scene
  double max_speed_mps = 0;  // at the end
  bool blew_up = false;
  double deepest_penetration_m = 0;  // hull against hull, margins not counted
};

struct DropResult {
  Scene scene;
  DropReport report;
};

// `counts[i]` parts of objects[i], in a random order. Throws InputError when a part is larger than
// the bin, or std::logic_error when a part has no convex pieces.
DropResult DropParts(const Bin& bin, const ObjectSet& objects, const std::vector<int>& counts,
                     Rng& rng, const DropOptions& options = {});

}  // namespace pickbed
