#pragma once

// What a depth camera delivers: colour registered to depth, and the intrinsics of both.

#include "scenes/camera.h"
#include "scenes/image.h"

namespace pickbed {

struct RgbdFrame {
  CameraIntrinsics intrinsics;
  Image<Rgb8> color;     // empty, or the size of depth_m
  Image<float> depth_m;  // metres along camera z, 0 = no reading
};

}  // namespace pickbed
