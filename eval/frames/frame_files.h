#pragma once

// Reads one frame of a depth camera from the files of a user, without a data set.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

// Files of a frame.
struct FrameFiles {
  // Color image, or a depth image or organised cloud if `depth` is empty.
  std::filesystem::path image;
  // PNG, TIFF, OpenEXR or NumPy file, or an organised cloud; registered to the color image.
  std::filesystem::path depth;
  std::string intrinsics;     // see ReadIntrinsics(); empty = fitted to the points of a cloud
  double depth_scale_mm = 0;  // mm per unit; 0 = of the intrinsics' file, else by the format
};

// A frame with facts about its files.
struct FrameOfFiles {
  RgbdFrame frame;
  double depth_scale_mm = 1;       // as used
  std::vector<std::string> notes;  // assumptions, one line each
};

// Returns whether the name of a file ends as an image or a cloud does, so that it is no scenario.
bool IsFrameFile(const std::filesystem::path& file);

// Reads a frame. Without a scale, integers are millimetres and floats metres. Values that are not
// positive and finite are no readings, and 65535 in 16 bits, too. Throws InputError with the file,
// the reason and a remedy: files that cannot be read, a color image without depth, depth of 8
// bits, images of different sizes, and intrinsics of an image of another size.
FrameOfFiles ReadFrameFiles(const FrameFiles& files);

}  // namespace pickbed::eval
