#pragma once

// Organised point clouds of depth cameras: PCD files of PCL, and PLY files.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

// Smallest depth of a cloud or a depth image. Shifted or otherwise wrong bytes often give a number
// near 0, which no sensor does.
inline constexpr double kMinDepth_m = 1e-12;
inline constexpr double kMaxDepth_m = 1e4;  // no camera and no scanner sees as far

// Fields of a cloud with the layout of an image, row by row.
struct CloudFile {
  struct Field {
    std::string name;             // as in the file, such as x, rgba or label
    bool is_float = true;         // else an integer
    std::vector<uint32_t> words;  // one for each point: the bytes of a float, or an integer
  };
  int width = 0, height = 0;
  std::vector<Field> fields;

  const Field* Find(const std::string& name) const;  // null if the file has no such field
};

// Size of the image that a cloud has; zero = unknown.
struct CloudSize {
  int width = 0, height = 0;
};

// Returns whether the name of the file ends in .pcd or .ply.
bool IsCloudFile(const std::filesystem::path& file);

// Reads a PCD file (binary or binary_compressed; each field has one value of four bytes) or a PLY
// file (binary_little_endian or ascii). A PLY file has its size in the element `camera`, as PCL
// writes it, or in comments or obj_info lines with num_cols and num_rows, or width and height.
// Otherwise `size` is used. Throws InputError with the file and the reason, also for clouds without
// the layout of an image.
CloudFile ReadCloudFile(const std::filesystem::path& file, const CloudSize& size = {});

// Returns the frame of a cloud with x, y, z in the camera frame and, optionally, color (rgb or
// rgba, or red, green and blue). `unit_m` is the length of one unit. The intrinsics are fitted to
// the points. A point that is not a number has no reading. Throws InputError with `name` for clouds
// without these fields, and for points that no pinhole camera shows in this layout.
RgbdFrame FrameOfCloud(const CloudFile& cloud, const std::string& name, double unit_m = 1);

// Decompresses a block in the LZF format (liblzf), which PCD uses. Returns exactly `size` bytes.
// Throws InputError with `name` for damaged data.
std::string DecompressLzf(const std::string& bytes, size_t size, const std::string& name);

}  // namespace pickbed::eval
