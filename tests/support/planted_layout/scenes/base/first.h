#pragma once

namespace pickbed::scenes {

// The first type of this name.
struct Twin {
  int count = 0;
};

}  // namespace pickbed::scenes
