#pragma once

// LINEMOD (Hinterstoisser et al., "Gradient Response Maps for Real-Time Detection of Texture-Less
// Objects", PAMI 2012) by OpenCV's rgbd module: templates of colour gradients and surface normals
// with OpenCV's settings by default, two pyramid levels, on crops enlarged to 128 x 128 px, about
// the size of parts in the images that it was made for.

#include <memory>

#include "perception/crop_method.h"

namespace pickbed {

// Templates of too few gradients or normals for OpenCV are left out.
std::unique_ptr<CropMethod> MakeLinemodMethod(const CropMethodSetup& setup);

}  // namespace pickbed
