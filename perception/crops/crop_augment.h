#pragma once

// Augmentation of training crops: random backgrounds, occluders, and errors of the crop center. It
// works on crops, so that views are rendered only once.

#include "perception/crops/crop.h"
#include "scenes/base/random.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct CropAugmentOptions {
  // Share of crops with a background of fractal noise in depth and color (Wohlhart and Lepetit,
  // CVPR 2015, 4.1). The others keep an empty background.
  double background_share = 0.5;
  double occluded_share = 0.7;  // share of crops with an occluder, cut from another crop
  double occluded_max = 0.5;    // maximum share of the object's pixels that it hides, 0..0.9
  int shift_px = 1;             // maximum shift of the crop center along x and y, both ways
  double shift_depth = 0.01;    // the same along the optical axis, over the crop's side
  void Visit(SettingsVisitor& v);
};

// Augments crop i of `pool` and appends it to `out` without a mask. The occluder is a random crop
// of `blockers`. Both sets must have masks.
void AppendAugmented(const CropSet& pool, size_t i, const CropSet& blockers,
                     const CropAugmentOptions& options, Rng& rng, CropSet& out);

}  // namespace pickbed::perception
