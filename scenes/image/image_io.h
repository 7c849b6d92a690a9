#pragma once

// Reads and writes PNG images: 8-bit color, 8-bit masks and 16-bit depth. Encodes JPEG for pages.

#include <filesystem>
#include <string>

#include "scenes/image/image.h"

namespace pickbed::scenes {

// The functions that read or write a file throw InputError with the path and the reason.

// Writes 8-bit color.
void WritePng(const std::filesystem::path& path, const Image<Rgb8>& image);
// Writes the 16-bit values as they are.
void WritePng16(const std::filesystem::path& path, const Image<uint16_t>& image);
// Writes a depth image in the units of DepthUnits(). `scale_mm` is BOP's depth_scale.
void WriteDepthPng(const std::filesystem::path& path, const Image<float>& depth_m,
                   double scale_mm = 0.1);
// Reads an image file as 8-bit color.
Image<Rgb8> ReadPng(const std::filesystem::path& path);
// Reads a PNG with one 16-bit channel.
Image<uint16_t> ReadPng16(const std::filesystem::path& path);
Image<uint8_t> ReadPng8(const std::filesystem::path& path);  // one channel

// Returns the bytes of a PNG. `level` is zlib's compression level, 0 (fastest) to 9 (smallest).
std::string EncodePng(const Image<Rgb8>& image, int level);
// Same for one 16-bit channel.
std::string EncodePng(const Image<uint16_t>& image, int level);
// Same for one 8-bit channel.
std::string EncodePng(const Image<uint8_t>& image, int level);

// Returns the bytes of a JPEG; `quality` is 1 to 100.
std::string EncodeJpeg(const Image<Rgb8>& image, int quality);
// Returns the image scaled down to `width_px` with its proportions kept. An image that is not wider
// is returned unchanged.
Image<Rgb8> Narrowed(const Image<Rgb8>& image, int width_px);

// Returns depth in units of `scale_mm`: depth_m * 1e3 / scale_mm, rounded. Values that do not fit
// into 16 bits (above 6.5 m at 0.1 mm) and NaN become 0 = no reading.
Image<uint16_t> DepthUnits(const Image<float>& depth_m, double scale_mm);

// Decodes an image of any known format (PNG, JPEG, ...) from memory. Throws InputError if the bytes
// are no image, a damaged one, or one that is too large.
Image<Rgb8> DecodeImage(const std::string& bytes);

}  // namespace pickbed::scenes
