#pragma once

// Depth images without gaps, for code that must not take a missing reading for free space.

#include "scenes/image/image.h"

namespace pickbed::scenes {

// Whether a pixel of a depth image (m) has a reading. Others are zero or not finite.
bool IsReading(float depth_m);

// Returns the depth (m) with filled gaps: a pixel without a reading gets the nearest depth among
// the readings that end its gap in the row and in the column. It is infinite where the whole row
// and the whole column have no reading.
Image<float> FilledDepth(const Image<float>& depth_m);

}  // namespace pickbed::scenes
