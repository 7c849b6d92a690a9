#pragma once

namespace pickbed::scenes {

// A type for the other planted headers.
struct Thing {
  int count = 0;
};

}  // namespace pickbed::scenes
