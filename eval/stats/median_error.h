#pragma once

// Median of an error with a confidence interval; scenes are the independent units.

#include <string>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

// Median with its 95 % interval.
struct ErrorMedian {
  double value = 0;                        // NaN without values
  Interval ci95{0, 0};                     // infinite where unknown
  ErrorMedian Times(double factor) const;  // converts the unit; `factor` > 0
};

// MedianOf the errors of each scene, with MedianInterval. The interval is unknown with fewer than
// kMinBinsOfInterval scenes or fewer than six values.
ErrorMedian MedianWithin(const ValueClusters& by_scene);

// Formats as "1.25 [0.98, 1.60]" with `digits` decimals, or "1.25 (too few bins)". An infinite end
// is "-"; the whole text is "-" without a value.
std::string MedianText(const ErrorMedian& median, int digits);

// CSV cells "1.25,0.98,1.60" with all digits; unknown values are empty.
std::string MedianCells(const ErrorMedian& median);

}  // namespace pickbed::eval
