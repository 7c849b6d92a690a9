#include "eval/frames/frame_files.h"
#include "eval/frames/region.h"
#include "scenes/image/image_io.h"
#include "scenes/image/number_image.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/png_sums.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 8, kHeight = 6;
constexpr const char* kIntrinsics = "20,20,4,3";

Image<float> Slope() {
  Image<float> depth_m(kWidth, kHeight);
  for (size_t i = 0; i < depth_m.size(); ++i) {
    depth_m.data()[i] = 0.5f + 0.01f * static_cast<float>(i);
  }
  return depth_m;
}

Contents PngSeeds() {
  return {EncodePng(Image<Rgb8>(9, 7), 3), EncodePng(Image<uint16_t>(9, 7), 3),
          EncodeJpeg(Image<Rgb8>(9, 7), 90)};
}

FuzzTarget PngChunkTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    const fs::path file = folder / "a.png";
    WriteFileAtomically(file, WithRightCheckSums(bytes));
    ReadPng(file);
    if (!HasColorChannels(file)) ReadNumberImage(file);
  };
  const auto seeds = [] {
    Image<Rgb8> color(9, 7);
    Image<uint16_t> depth(9, 7);
    for (size_t i = 0; i < color.size(); ++i) {
      const auto number = static_cast<uint8_t>(31 * i);
      color.data()[i] = {number, static_cast<uint8_t>(number / 2), 7};
      depth.data()[i] = static_cast<uint16_t>(500 + 37 * i);
    }
    return Contents{EncodePng(Image<uint16_t>(9, 7), 3), EncodePng(depth, 3), EncodePng(color, 3)};
  };
  return {"png_chunks", run, seeds};
}

// A depth image of floats in the format of an extension, as `pickbed estimate` reads it.
FuzzTarget DepthTarget(const std::string& extension) {
  const std::string name = "depth." + extension;
  const auto run = [name](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / name, bytes);
    FrameFiles files;
    files.image = folder / name;
    files.intrinsics = kIntrinsics;
    const RgbdFrame frame = ReadFrameFiles(files).frame;
    for (const float depth_m : frame.depth_m.pixels()) {
      RequireLaw(depth_m >= 0 && depth_m <= 1e4f, "a depth is 0 or in front of the camera");
    }
  };
  const auto seeds = [name] {
    return Contents{BytesOfFile(name, [](const fs::path& file) { WriteFloats(file, Slope()); })};
  };
  FuzzTarget target{"depth_" + extension, run, seeds};
  target.reads_file = false;  // the intrinsics can be at fault, too
  return target;
}

// A JPEG as the color image of a frame.
FuzzTarget JpegTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "color.jpg", bytes);
    WriteFloats(folder / "depth.npy", Slope());
    FrameFiles files;
    files.image = folder / "color.jpg";
    files.depth = folder / "depth.npy";
    files.intrinsics = kIntrinsics;
    ReadFrameFiles(files);
  };
  const auto seeds = [] {
    Image<Rgb8> color(kWidth, kHeight);
    for (size_t i = 0; i < color.size(); ++i) {
      color.data()[i] = {static_cast<uint8_t>(5 * i), 90, static_cast<uint8_t>(255 - 3 * i)};
    }
    return Contents{EncodeJpeg(color, 90), EncodeJpeg(color, 40)};
  };
  return {"jpeg", run, seeds};
}

// The mask of a region of interest.
FuzzTarget MaskTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "mask.png", WithRightCheckSums(bytes));
    RgbdFrame frame;
    frame.intrinsics = CameraIntrinsics(kWidth, kHeight, 20, 20, 4, 3);
    frame.depth_m = Slope();
    const RegionSpec spec = ParseRegion((folder / "mask.png").string());
    const ImageRegion region = MakeRegion(spec, frame, {}, {});
    RequireReadingsIn(region, frame, spec.mask);
  };
  const auto seeds = [] {
    Image<uint8_t> mask(kWidth, kHeight, 0);
    for (int x = 2; x < 6; ++x) mask(x, 3) = 255;
    Image<Rgb8> color(kWidth, kHeight);
    color(1, 1) = {255, 0, 0};
    return Contents{EncodePng(mask, 3), EncodePng(color, 3)};
  };
  return {"region_mask", run, seeds};
}

}  // namespace

std::vector<FuzzTarget> ImageTargets() {
  return {
      OneFile(
          "png", "a.png", [](const fs::path& file) { ReadPng(file); }, PngSeeds),
      OneFile(
          "png16", "a.png", [](const fs::path& file) { ReadPng16(file); },
          [] { return Contents{EncodePng(Image<uint16_t>(9, 7), 3)}; }),
      PngChunkTarget(),
      JpegTarget(),
      DepthTarget("npy"),
      DepthTarget("tiff"),
      DepthTarget("exr"),
      MaskTarget(),
  };
}

}  // namespace pickbed::tests
