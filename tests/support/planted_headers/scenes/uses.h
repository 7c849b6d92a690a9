#pragma once

#include <vector>

namespace pickbed::scenes {

// Misses scenes/thing.h, which comes before this header in alphabetical order.
struct Uses {
  std::vector<Thing> all;
};

}  // namespace pickbed::scenes
