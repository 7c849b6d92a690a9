#pragma once

// Numbers with intervals. The numerics are Boost.Math's.
//
// Scenes are the units: picks of one bin and instances of one image are not independent, so that an
// interval is made of what each scene adds (a Cluster), whatever the number of tries in it.

#include <span>
#include <vector>

namespace pickbed {

struct Interval {
  double low = 0;
  double high = 1;
};

// Wilson score interval (Wilson 1927) of successes / attempts; [0, 1] for no attempts. Only where
// the attempts are independent.
Interval WilsonInterval(int successes, int attempts, double confidence = 0.95);

// Standard normal deviations on each side that hold `confidence` of it.
double TwoSidedZ(double confidence);
// The same of Student's t; `degrees` of freedom need not be whole, infinity is the normal.
double TwoSidedT(double confidence, double degrees);

// What one independent unit (a scene) adds to a rate: `hits` of `tries`.
struct Cluster {
  int hits = 0;
  int tries = 0;
};
Cluster SumOf(std::span<const Cluster> clusters);
// Hits of tries, 0 where nothing was tried.
double RateOf(std::span<const Cluster> clusters);

// Interval of sum(hits) / sum(tries) when tries of one cluster are not independent, and clusters
// differ in size. Wilson's form with an effective number of tries p q / v (Korn and Graubard 1998;
// Dean and Pagano 2015), where v is the cluster jackknife's variance of the ratio, and Student's t
// with Satterthwaite's degrees of freedom from the fourth moment of the clusters' residuals
// (statistics.cpp). 95 % intervals cover 93 to 97 % for 40 clusters or more and rates of .1 to .9
// (tests/figures/interval_figures.cpp), which percentile bootstraps do not reach.
// Where each cluster tried once it is Wilson's interval; where all tries agree there is nothing to
// tell how alike those of a cluster are, and each cluster counts as one try. [0, 1] when nothing
// was tried. Clusters without tries change nothing.
Interval ClusterInterval(std::span<const Cluster> clusters, double confidence = 0.95);

// Interval of by how much the rate rises from `before` to `after`, which hold the same units in the
// same order: with two pseudo-scenes of one try, one that is hit before alone and one after alone
// (Bonett and Price 2012), the linearised variance over units and Student's t. Where no unit
// differs each counts as one try, so that the interval is never without width. [-1, 1] when nothing
// was tried in either. Throws std::logic_error when they differ in number.
Interval PairedInterval(std::span<const Cluster> before, std::span<const Cluster> after,
                        double confidence = 0.95);

// Values of one unit after the other, such as pose errors of the poses of each scene.
using ValueClusters = std::vector<std::vector<double>>;

// Median of all values, the lower one of two; NaN of none.
double MedianOf(const ValueClusters& clusters);
// Woodruff (1952): the values at the ends of the ClusterInterval of the share that is at or below
// the median. Where no cluster has more than one value, the order statistics that hold the median
// of independent values in `confidence` at least (David and Nagaraja 2003, sec. 7.1), which 95 %
// needs six of. Infinite values may be among them. [-inf, inf] where nothing is known.
Interval MedianInterval(const ValueClusters& clusters, double confidence = 0.95);

}  // namespace pickbed
