#pragma once

// Labelled clouds of real sensors: files in the PCD format of PCL with the layout of an image.

#include <cstdint>
#include <filesystem>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

struct LabelledCloud {
  RgbdFrame frame;  // color is empty if the file has none
  Image<uint16_t> labels;
};

// Reads an organised cloud with the fields x, y, z (m, in the camera frame) and label, and
// optionally rgb or rgba, see ReadCloudFile() and FrameOfCloud(). Throws InputError with the file
// and the reason for other files, for damaged ones, and for points that no pinhole camera shows in
// this layout.
LabelledCloud ReadLabelledCloud(const std::filesystem::path& file);

}  // namespace pickbed::eval
