#pragma once

// Labelled clouds of real sensors: files in the PCD format of PCL with the layout of an image.

#include <cstdint>
#include <filesystem>
#include <string>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

struct LabelledCloud {
  RgbdFrame frame;  // colour is empty if the file has none
  Image<uint16_t> labels;
};

// Reads an organised cloud with the fields x, y, z (m, in the camera frame) and label, and
// optionally rgb or rgba. Each field must have four bytes. The intrinsics are fitted to the points;
// a point that is not a number has no reading. Data may be binary or binary_compressed.
// Throws InputError with the file and the reason for other files, for damaged ones, and for points
// that no pinhole camera shows in this layout.
LabelledCloud ReadLabelledCloud(const std::filesystem::path& file);

// Decompresses a block in the LZF format (liblzf), which PCD uses. Returns exactly `size` bytes.
// Throws InputError with `name` for damaged data.
std::string DecompressLzf(const std::string& bytes, size_t size, const std::string& name);

}  // namespace pickbed::eval
