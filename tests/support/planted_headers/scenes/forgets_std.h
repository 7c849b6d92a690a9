#pragma once

#include "scenes/thing.h"

namespace pickbed::scenes {

// Misses <vector>.
struct Things {
  std::vector<Thing> all;
};

}  // namespace pickbed::scenes
