#include "eval/statistics.h"

#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace pickbed {

Interval WilsonInterval(int successes, int attempts, double confidence) {
  if (attempts <= 0) return {0, 1};
  const double z = boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
  const double n = attempts;
  const double p = successes / n;
  const double center = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  // The ends are exact at the extremes, where rounding would leave 0.9999999999999999.
  return {successes == 0 ? 0.0 : center - half, successes == attempts ? 1.0 : center + half};
}

}  // namespace pickbed
