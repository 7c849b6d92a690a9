#pragma once

// Pictures of a tolerance map.

#include "eval/tolerance_figures.h"
#include "scenes/image.h"

namespace pickbed {

// The part with the axes of its frame, the hand with those of its own, key figures, and the share
// of picks that succeed against the error along each axis with 95 % bands; the region that still
// succeeds is shaded.
Image<Rgb8> DrawToleranceSheet(const ToleranceStudy& study, const ToleranceFigures& figures);

// A heat map a pair: percent of picks that succeed, in each cell.
Image<Rgb8> DrawPairSheet(const ToleranceFigures& figures);

// "-4.1 .. +3.8 mm", "-20.0 or less .. +3.8 mm" where the map ends first.
std::string RegionText(const ToleranceRegion& region, const char* unit);

}  // namespace pickbed
