#pragma once

// Brightness edges of the color image, at its full resolution. Depth cameras smooth small holes
// away, which color images show.

#include "perception/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::perception {

// Gradient of the smoothed brightness, in grey levels per pixel. It is empty without a color
// image.
struct ColorEdges {
  CameraIntrinsics intrinsics;
  Image<float> du, dv;
  bool empty() const { return du.empty(); }
};

// Returns the gradient of a color image of a camera. The brightness is smoothed by a Gaussian of
// one pixel. Returns an empty result for an empty image. The result is the same for any number of
// threads.
ColorEdges FindColorEdges(const CameraIntrinsics& intrinsics, const Image<Rgb8>& color,
                          int threads = 1);

}  // namespace pickbed::perception
