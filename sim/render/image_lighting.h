#pragma once

// Ambient occlusion and shadows of a picture, computed from its depth image and normals.

#include <Eigen/Core>

#include "scenes/camera/camera.h"
#include "scenes/image/image.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// Returns the share of the surroundings that each pixel sees, estimated in the depth image
// ("Screen-space ambient occlusion", Mittring, "Finding Next Gen: CryEngine 2", SIGGRAPH 2007
// courses). `normals_C` are unit vectors. Pixels without depth get 1.
Image<float> AmbientOcclusion(const CameraIntrinsics& k, const Image<float>& depth_m,
                              const Image<Eigen::Vector3f>& normals_C, int threads);

// Returns the share of the lamp's light that is not shadowed at each pixel, smooth at the edges of
// shadows. `thin` is lit without shadows and `lit` with them, both with one pixel per pixel of the
// picture. `key_C` is the lamp in the camera frame.
Image<float> ShadowFactors(const CameraIntrinsics& k, const RenderedImage& thin,
                           const Image<Rgb8>& lit, const Eigen::Vector3f& key_C, int threads);

}  // namespace pickbed::sim
