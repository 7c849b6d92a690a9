#include "eval/frames/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>

#include "eval/frames/cloud_file.h"
#include "eval/frames/intrinsics_file.h"
#include "scenes/base/error.h"
#include "scenes/image/image_io.h"
#include "scenes/image/number_image.h"

namespace pickbed::eval {
namespace {

constexpr double kMetersInMm = 1000;

// Returns whether 16-bit values were made from 8-bit ones: all are multiples of 256 or of 257.
bool HasEightBits(const Image<float>& values) {
  constexpr size_t kMinDistinct = 8;
  std::set<int> distinct;
  bool by_256 = true, by_257 = true;
  for (const float value : values.pixels()) {
    const int number = static_cast<int>(value);
    by_256 = by_256 && number % 256 == 0;
    by_257 = by_257 && number % 257 == 0;
    if (!by_256 && !by_257) return false;
    if (distinct.size() < kMinDistinct) distinct.insert(number);
  }
  return distinct.size() >= kMinDistinct;
}

void RequireDepthBits(const NumberImage& image, const std::string& name) {
  CheckInput(image.is_float || image.bits > 8,
             name +
                 ": has 8 bits per pixel, so it is a picture of the depth with 256 levels; "
                 "export the depth with 16 bits or as floats");
  CheckInput(image.is_float || image.bits > 16 || !HasEightBits(image.values),
             name +
                 ": its 16-bit values were made from 8 bits, so it has only 256 levels; export "
                 "the depth itself with 16 bits or as floats");
}

Image<float> ReadDepth(const std::filesystem::path& file, double given_scale_mm,
                       FrameOfFiles& result) {
  NumberImage image = ReadNumberImage(file);
  RequireDepthBits(image, file.string());
  result.depth_scale_mm =
      given_scale_mm > 0 ? given_scale_mm : (image.is_float ? kMetersInMm : 1.0);
  if (given_scale_mm <= 0) {
    result.notes.push_back(fmt::format("{}: its {} are taken as {}", file.string(),
                                       image.is_float ? "floats" : "integers",
                                       image.is_float ? "metres" : "millimetres"));
  }
  const auto unit_m = static_cast<float>(1e-3 * result.depth_scale_mm);
  constexpr float kNoReading16 = 65535, kRenderedSky = 1e10f;  // the latter as Blender writes it
  for (float& value : image.values.pixels()) {
    const bool is_no_reading =
        image.is_float ? value == kRenderedSky || value == std::numeric_limits<float>::max()
                       : image.bits == 16 && value == kNoReading16;
    // Programs mark holes with negative numbers as -32768, or with the lowest one of a type.
    const bool is_mark = value >= -kRenderedSky || value == std::numeric_limits<float>::lowest();
    CheckInput(!image.is_float || !std::isfinite(value) || is_mark,
               fmt::format("{}: a reading is {:g}, so its bytes are damaged; get the file again",
                           file.string(), value));
    const bool is_hole = !std::isfinite(value) || value <= 0 || is_no_reading;
    value = is_hole ? 0 : value * unit_m;
    CheckInput(value == 0 || value >= kMinDepth_m,
               fmt::format("{}: a reading is {:g} m, so its bytes are damaged; get the file again, "
                           "or give the depth scale",
                           file.string(), value));
    CheckInput(value <= kMaxDepth_m,
               fmt::format("{}: a reading is {:g} m, over {:g} m; get the file again, or give the "
                           "depth scale",
                           file.string(), value, kMaxDepth_m));
  }
  return std::move(image.values);
}

void TakeIntrinsics(const FrameFiles& files, const GivenIntrinsics& given, FrameOfFiles& result) {
  const std::string name =
      files.intrinsics.find(',') == std::string::npos ? files.intrinsics : "intrinsics";
  result.frame.intrinsics =
      given.ForImage(result.frame.depth_m.width(), result.frame.depth_m.height(), name);
  if (given.is_distorted) {
    result.notes.push_back(name +
                           ": has lens distortion, which is ignored; rectify the images first if "
                           "straight edges look bent");
  }
}

void RequireSameSize(const FrameFiles& files, const std::filesystem::path& depth,
                     const RgbdFrame& frame) {
  CheckInput(frame.color.empty() || (frame.color.width() == frame.depth_m.width() &&
                                     frame.color.height() == frame.depth_m.height()),
             fmt::format("{}: is {}x{} px but the depth image {} {}x{} px; give depth that is "
                         "registered to the color image",
                         files.image.string(), frame.color.width(), frame.color.height(),
                         depth.string(), frame.depth_m.width(), frame.depth_m.height()));
}

}  // namespace

bool IsFrameFile(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  static const std::set<std::string> kExtensions{".png",  ".jpg", ".jpeg", ".bmp", ".tif",
                                                 ".tiff", ".exr", ".npy",  ".pcd", ".ply"};
  return kExtensions.contains(extension);
}

FrameOfFiles ReadFrameFiles(const FrameFiles& files) {
  FrameOfFiles result;
  std::optional<GivenIntrinsics> given;
  if (!files.intrinsics.empty()) given = ReadIntrinsics(files.intrinsics);
  double scale_mm = files.depth_scale_mm;
  const bool is_only_depth = files.depth.empty();
  const std::filesystem::path& depth = is_only_depth ? files.image : files.depth;
  if (!is_only_depth) result.frame.color = ReadPng(files.image);
  if (IsCloudFile(depth)) {
    CloudSize size{result.frame.color.width(), result.frame.color.height()};
    if (size.width == 0 && given) size = {given->width, given->height};
    const CloudFile cloud = ReadCloudFile(depth, size);
    result.depth_scale_mm = scale_mm > 0 ? scale_mm : kMetersInMm;
    Image<Rgb8> color = std::move(result.frame.color);
    result.frame = FrameOfCloud(cloud, depth.string(), 1e-3 * result.depth_scale_mm);
    if (!color.empty()) result.frame.color = std::move(color);
  } else {
    CheckInput(given.has_value(),
               fmt::format("{}: the intrinsics of the camera are needed; give FX,FY,CX,CY in px or "
                           "a file with them",
                           depth.string()));
    CheckInput(!is_only_depth || !HasColorChannels(depth),
               fmt::format("{}: is a color image, and poses are found in depth; give its depth "
                           "image, too",
                           depth.string()));
    if (scale_mm <= 0) scale_mm = given->depth_scale_mm.value_or(0);
    result.frame.depth_m = ReadDepth(depth, scale_mm, result);
  }
  RequireSameSize(files, depth, result.frame);
  if (given) {
    TakeIntrinsics(files, *given, result);
  } else {
    const CameraIntrinsics& k = result.frame.intrinsics;
    result.notes.push_back(fmt::format(
        "{}: intrinsics fitted to the points: fx {:.1f} fy {:.1f} cx {:.1f} cy {:.1f} px",
        depth.string(), k.fx(), k.fy(), k.cx(), k.cy()));
  }
  return result;
}

}  // namespace pickbed::eval
