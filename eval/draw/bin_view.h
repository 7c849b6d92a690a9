#pragma once

// Cameras that show only the bin, for pictures for people.

#include <algorithm>

#include "eval/layer.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

inline constexpr char kPictureFile[] = "picture.png";  // of a bin, for people

// Returns the part of the camera's image that contains the bin with its outer rim, and a margin
// around it. It is limited to the image; the whole image if the bin is not in front of the camera
// or not in view.
ImageBox BinRegion(const Camera& camera, const Bin& bin);

// Returns a camera with the same pose whose image is `region` in a width of about `width_px`.
Camera WindowOf(const Camera& camera, const ImageBox& region, int width_px);

// Returns the camera of a picture of the bin: BinRegion() in twice its size, but at most 1600 px
// wide.
Camera BinCamera(const Camera& camera, const Bin& bin);

// Returns the intrinsics of the same image in `factor` times its size.
CameraIntrinsics EnlargedBy(const CameraIntrinsics& intrinsics, int factor);

// Returns `region` of an image.
template <typename T>
Image<T> Cropped(const Image<T>& image, const ImageBox& region) {
  Image<T> cropped(region.width, region.height);
  for (int y = 0; y < region.height; ++y) {
    std::copy_n(image.row(region.y + y) + region.x, region.width, cropped.row(y));
  }
  return cropped;
}

}  // namespace pickbed::eval
