#pragma once

// Pictures of a tolerance map.

#include "eval/tolerance/statistics.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Sheet with the object and its axes, the hand and its axes, key statistics, and one curve per
// error axis. A curve shows the share of successful picks by error, with 95 % bands; the tolerated
// region is shaded.
Image<Rgb8> DrawToleranceSheet(const ToleranceStudy& study, const ToleranceStatistics& statistics);

// One heat map per pair of axes: percentage of successful picks in each cell.
Image<Rgb8> DrawPairSheet(const ToleranceStatistics& statistics);

// "-4.1 .. +3.8 mm", or "-20.0 or less .. +3.8 mm" if the region extends beyond the map.
std::string RegionText(const ToleranceRegion& region, const char* unit);

}  // namespace pickbed::eval
