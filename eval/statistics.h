#pragma once

// Numbers with intervals. The numerics are Boost.Math's.

#include <cstdint>
#include <span>

namespace pickbed {

struct Interval {
  double low = 0;
  double high = 1;
};

// Wilson score interval (Wilson 1927) of successes / attempts; [0, 1] for no attempts.
Interval WilsonInterval(int successes, int attempts, double confidence = 0.95);

// Standard normal deviations on each side that hold `confidence` of it.
double TwoSidedZ(double confidence);

// What one independent unit (a scene) adds to a rate: `hits` of `tries`.
struct Cluster {
  int hits = 0;
  int tries = 0;
};

// Interval of sum(hits) / sum(tries) when tries of one cluster are not independent: percentiles of
// the rate over `resamples` draws of as many clusters with replacement (Davison and Hinkley 1997,
// sec. 3.8). [0, 1] when nothing was tried. The same seed gives the same interval.
Interval ClusterBootstrap(std::span<const Cluster> clusters, double confidence = 0.95,
                          int resamples = 2000, uint64_t seed = 0);

// Interval of by how much the rate rises from `before` to `after`, which hold the same units in the
// same order: units are drawn, with what they add to both. [-1, 1] when nothing was tried in
// either. Throws std::logic_error when they differ in number.
Interval PairedBootstrap(std::span<const Cluster> before, std::span<const Cluster> after,
                         double confidence = 0.95, int resamples = 2000, uint64_t seed = 0);

}  // namespace pickbed
