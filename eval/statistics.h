#pragma once

// Numbers with intervals. The numerics are Boost.Math's.

namespace pickbed {

struct Interval {
  double low = 0;
  double high = 1;
};

// Wilson score interval (Wilson 1927) of successes / attempts; [0, 1] for no attempts.
Interval WilsonInterval(int successes, int attempts, double confidence = 0.95);

}  // namespace pickbed
