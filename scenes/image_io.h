#pragma once

// PNG in and out: 8-bit colour, 8-bit masks and 16-bit depth. JPEG out, for pages.

#include <filesystem>
#include <optional>
#include <string>

#include "scenes/image.h"

namespace pickbed {

// All throw InputError with the path and reason.
void WritePng(const std::filesystem::path& path, const Image<Rgb8>& image);
void WritePng16(const std::filesystem::path& path, const Image<uint16_t>& image);
// depth_m * 1e3 / scale_mm, rounded; BOP's depth_scale. What 16 bits cannot hold (6.5 m at 0.1 mm)
// and what is no number becomes 0 = no reading.
void WriteDepthPng(const std::filesystem::path& path, const Image<float>& depth_m,
                   double scale_mm = 0.1);
Image<Rgb8> ReadPng(const std::filesystem::path& path);
Image<uint16_t> ReadPng16(const std::filesystem::path& path);
Image<uint8_t> ReadPng8(const std::filesystem::path& path);  // one channel

// The bytes of a PNG; `level` is zlib's, 0 (fastest) to 9 (smallest).
std::string EncodePng(const Image<Rgb8>& image, int level);
std::string EncodePng(const Image<uint16_t>& image, int level);
std::string EncodePng(const Image<uint8_t>& image, int level);

// The bytes of a JPEG; `quality` 1 .. 100.
std::string EncodeJpeg(const Image<Rgb8>& image, int quality);
// The image made smaller, in proportion, where it is wider than this.
Image<Rgb8> Narrowed(const Image<Rgb8>& image, int width_px);

// As WriteDepthPng rounds.
Image<uint16_t> DepthUnits(const Image<float>& depth_m, double scale_mm);

// Any image format from memory (PNG, JPEG...); nothing when the bytes are none of them.
std::optional<Image<Rgb8>> DecodeImage(const std::string& bytes);

}  // namespace pickbed
