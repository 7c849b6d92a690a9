#include "eval/page/ticks.h"

#include <cmath>

namespace pickbed::eval {
namespace {

double TickStep(double span) {
  const double rough = span / 5, power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= 0.999 * rough) return factor * power;
  }
  return 10 * power;
}

}  // namespace

std::vector<double> RoundTicks(double min, double max) {
  if (!(max > min)) return {min};
  constexpr double kSlack = 1e-9;  // rounding tolerance at the ends, as a share of a step
  const double step = TickStep(max - min);
  const double first = std::ceil(min / step - kSlack), last = std::floor(max / step + kSlack);
  std::vector<double> ticks;
  for (double i = first; i <= last; ++i)
    ticks.push_back(i * step + 0.0);  // + 0.0 avoids minus zero
  return ticks;
}

}  // namespace pickbed::eval
