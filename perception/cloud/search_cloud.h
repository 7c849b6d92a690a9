#pragma once

// The cloud in which an estimator searches: the frame at the resolution that its objects need.

#include <optional>

#include "perception/cloud/organized_cloud.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

// Diameter of the smallest object, in px, below which a frame is not reduced. Verifiers and normal
// windows are tuned for objects of 60 to 120 px.
inline constexpr double kSearchDiameter_px = 76;

// Returns how many pixels per axis become one, at least 1 and at most the smaller side of the
// image. An object of `smallest_diameter_m` at `distance_m` from the camera keeps a diameter of
// kSearchDiameter_px.
int BinningFor(const CameraIntrinsics& intrinsics, double distance_m, double smallest_diameter_m);

// Returns the frame with each block of `factor` x `factor` pixels as one pixel. Its depth is the
// mean of the readings near their median, and 0 if less than half of the block has readings. Its
// color is the mean of the block. Pixels right of and below the last whole block are dropped. The
// result is the same for any number of threads.
RgbdFrame BinnedFrame(const RgbdFrame& frame, int factor, int threads = 1);

// Returns the diameter of the smallest of the objects, m; infinite without objects.
double SmallestDiameter_m(const ObjectSet& objects);

// Preprocesses a frame as BuildCloud() does, after binning by `factor`; see BinningFor(). A block
// is in the region if its center pixel is. Without `fits_background`, no plane is looked for. The
// result is the same for any number of threads.
OrganizedCloud SearchCloud(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                           int factor, const Image<uint8_t>* region = nullptr,
                           bool fits_background = true, int threads = 1);

}  // namespace pickbed::perception
