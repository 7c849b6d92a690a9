#pragma once

// Reads images whose pixels are numbers, such as depth: PNG, TIFF, OpenEXR and NumPy files.

#include <filesystem>
#include <string>

#include "scenes/image/image.h"

namespace pickbed::scenes {

// An image with one channel, and how the file stores its pixels.
struct NumberImage {
  Image<float> values;  // in the unit of the file; NaN and infinities are kept
  int bits = 16;        // of a pixel
  bool is_float = false;
};

// Reads PNG, TIFF and BMP with integers or floats, OpenEXR with one channel (Y or Z), and NumPy
// arrays (.npy) of shape (height, width) or (height, width, 1) with integers or floats. Throws
// InputError with the path and the reason for other files, and for an image with several channels.
NumberImage ReadNumberImage(const std::filesystem::path& path);

// Returns whether the file is an image with several channels, such as a color image. False for
// files that are no image, and for NumPy arrays.
bool HasColorChannels(const std::filesystem::path& path);

// Writes 32-bit floats as OpenEXR, TIFF or NumPy array, by the extension of the path (.exr, .tif,
// .tiff, .npy). Throws InputError with the path and the reason.
void WriteFloats(const std::filesystem::path& path, const Image<float>& values);

}  // namespace pickbed::scenes
