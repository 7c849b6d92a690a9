#pragma once

// Checks of the bytes of an image, which OpenCV does not make. Its libraries repair damaged images
// silently.

#include <cstdint>
#include <string>
#include <string_view>

namespace pickbed::scenes {

// The largest image that is decoded. A PNG of a megabyte can hold an image of gigabytes.
inline constexpr int64_t kMaxPixels = int64_t{1} << 26;

// Returns the fault of a PNG, a JPEG, the header of an OpenEXR file or the directories of a TIFF as
// a clause: "the PNG has 3 bytes after its end". Empty: the image is whole, or of another format.
// It decodes a JPEG to find its faults, so check its size first; a PNG of more than kMaxPixels has
// a fault.
std::string FaultOfImage(std::string_view bytes);

// Returns the check sum that a PNG has of each chunk: of its name and content (RFC 2083, section
// 15).
uint32_t PngCheckSum(std::string_view bytes);

// Whether the bytes begin as a PNG or a JPEG does.
bool IsPng(std::string_view bytes);
bool IsJpeg(std::string_view bytes);

}  // namespace pickbed::scenes
