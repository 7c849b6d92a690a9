#pragma once

namespace pickbed::scenes {

// A second type with the name of a type in scenes/thing.h.
struct Thing {
  double length_m = 0;
};

}  // namespace pickbed::scenes
