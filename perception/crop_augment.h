#pragma once

// What a crop is varied by while a network learns from it: backgrounds, things before it, and a
// centre that is not quite right. All of it works on crops, so that views are rendered once.

#include "perception/crop.h"
#include "scenes/random.h"
#include "scenes/settings.h"

namespace pickbed {

struct CropAugmentOptions {
  // Of crops whose background is fractal noise in depth and colour (Wohlhart and Lepetit, CVPR
  // 2015, 4.1); the others keep an empty one.
  double background_share = 0.5;
  double occluded_share = 0.7;  // of crops that have a piece of another crop before the part
  double occluded_max = 0.5;    // of the part's pixels that such a piece hides at most, 0..0.9
  int shift_px = 1;             // of the crop's centre, both ways along x and y
  double shift_depth = 0.01;    // the same along the optical axis, over the crop's side
  void Visit(SettingsVisitor& v);
};

// Row i of `pool` so varied; appended to `out` without a mask. What stands before the part is a
// random row of `blockers`. Both have masks.
void AppendAugmented(const CropSet& pool, size_t i, const CropSet& blockers,
                     const CropAugmentOptions& options, Rng& rng, CropSet& out);

}  // namespace pickbed
