#pragma once

// Draws a failure budget as PNG charts.

#include "eval/budget/charts.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Draws a bar from 0 to 100 %, one bar per step in the color of its stage, and the remaining picks
// at the bottom. Each step starts where the previous one ends. Bars show count, share and interval.
Image<Rgb8> DrawWaterfall(const Waterfall& waterfall);

// Draws gains in percentage points with 95 % intervals: one line per row, two series in two
// colors.
Image<Rgb8> DrawGains(const GainRows& gains);

}  // namespace pickbed::eval
