#pragma once

// The median of an error, with what scenes as units tell of it.

#include <string>

#include "eval/statistics.h"

namespace pickbed {

struct ErrorMedian {
  double value = 0;                        // NaN of no values
  Interval ci95{0, 0};                     // infinite ends where nothing is known of them
  ErrorMedian Times(double factor) const;  // in another unit; `factor` > 0
};

// MedianOf of the errors of each scene, with MedianInterval. Of one scene, or fewer than six
// values, both ends are infinite.
ErrorMedian MedianWithin(const ValueClusters& by_scene);

// "1.25 [0.98, 1.60]" with so many digits behind the point; "-" for an end that is not known, and
// for the whole where there is no value.
std::string MedianText(const ErrorMedian& median, int digits);

// "1.25,0.98,1.60", each to all its digits; empty cells for what is not known.
std::string MedianCells(const ErrorMedian& median);

}  // namespace pickbed
