#pragma once

// Output of a depth camera: color registered to depth, and the intrinsics of both.

#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::scenes {

struct RgbdFrame {
  CameraIntrinsics intrinsics;
  Image<Rgb8> color;     // empty, or the size of depth_m
  Image<float> depth_m;  // metres along camera z, 0 = no reading
};

}  // namespace pickbed::scenes
