#pragma once

// LINEMOD (Hinterstoisser et al., "Gradient Response Maps for Real-Time Detection of Texture-Less
// Objects", PAMI 2012) with OpenCV's rgbd module: templates of color gradients and surface
// normals. It uses OpenCV's default settings and two pyramid levels. Crops are enlarged to 128 x
// 128 px, about the size of objects in the images for which it was designed.

#include <memory>

#include "perception/crop_methods/crop_method.h"

namespace pickbed::perception {

// Templates with too few gradients or normals for OpenCV are skipped. Throws InputError if an
// object has no template left.
std::unique_ptr<CropMethod> MakeLinemodMethod(const CropMethodSetup& setup);

}  // namespace pickbed::perception
