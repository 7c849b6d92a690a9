#include <fmt/format.h>

#include "eval/frames/frame_files.h"
#include "eval/frames/intrinsics_file.h"
#include "eval/segments/labelled_cloud.h"
#include "scenes/image/number_image.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 8, kHeight = 6;

Eigen::Vector3f PointAt(int pixel) {
  return {0.01f * static_cast<float>(pixel % kWidth - 4),
          0.01f * static_cast<float>(pixel / kWidth - 3), 0.5f};
}

std::string CloudPcd(bool has_labels) {
  std::string pcd = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z {0}rgb\nSIZE 4 4 4 {1}4\nTYPE F F F {2}U\nCOUNT 1 1 "
      "1 {3}1\nWIDTH 8\nHEIGHT 6\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 48\nDATA binary\n",
      has_labels ? "label " : "", has_labels ? "4 " : "", has_labels ? "U " : "",
      has_labels ? "1 " : "");
  for (int pixel = 0; pixel < kWidth * kHeight; ++pixel) {
    for (const float coordinate : PointAt(pixel)) PutNumber(coordinate, pcd);
    if (has_labels) PutNumber(static_cast<uint32_t>(pixel % 3), pcd);
    PutNumber(uint32_t{0x808080}, pcd);
  }
  return pcd;
}

std::string CloudPly(bool is_text, const std::string& size) {
  std::string ply = fmt::format(
      "ply\nformat {} 1.0\n{}element vertex 48\nproperty float x\nproperty float y\nproperty float "
      "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      is_text ? "ascii" : "binary_little_endian", size);
  for (int pixel = 0; pixel < kWidth * kHeight; ++pixel) {
    const Eigen::Vector3f p = PointAt(pixel);
    if (is_text) {
      ply += fmt::format("{} {} {} 16 32 {}\n", p.x(), p.y(), p.z(), pixel);
      continue;
    }
    for (const float coordinate : p) PutNumber(coordinate, ply);
    ply += std::string("\x10\x20") + static_cast<char>(pixel);
  }
  return ply;
}

void RequireFrame(const RgbdFrame& frame) {
  const CameraIntrinsics& k = frame.intrinsics;
  RequireLaw(k.width() == frame.depth_m.width() && k.height() == frame.depth_m.height(),
             "the intrinsics have the size of the image");
  RequireLaw(k.fx() > 0 && k.fy() > 0 && k.cx() < k.width() && k.cy() < k.height(),
             "the camera sees the image");
  for (const float depth_m : frame.depth_m.pixels()) {
    RequireLaw(depth_m >= 0 && depth_m <= 1e4f, "a depth is 0 or in front of the camera");
  }
}

FuzzTarget CloudTarget(const std::string& extension, std::function<Contents()> seeds) {
  const auto read = [](const fs::path& file) {
    FrameFiles files;
    files.image = file;
    RequireFrame(ReadFrameFiles(files).frame);
  };
  return OneFile("cloud_" + extension, "cloud." + extension, read, std::move(seeds));
}

// Each form that ReadIntrinsics() knows.
Contents Intrinsics() {
  return {
      "{\"cx\": 4, \"cy\": 3, \"depth_scale\": 1.0, \"fx\": 20, \"fy\": 20, \"height\": 6, "
      "\"width\": 8}\n",
      "{\"cam_K\": [20.0, 0.0, 4.0, 0.0, 20.0, 3.0, 0.0, 0.0, 1.0], \"depth_scale\": 0.5}\n",
      "image_width: 8\nimage_height: 6\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [20.0, 0, 4.0, 0, 20.0, 3.0, 0, 0, 1]\ndistortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n",
      "{\"width\": 8, \"height\": 6, \"intrinsic_matrix\": [20, 0, 0, 0, 20, 0, 4, 3, 1]}\n",
      "{\"fx\": 20, \"fy\": 20, \"ppx\": 4, \"ppy\": 3, \"coeffs\": [0, 0, 0, 0, 0], \"width\": 8, "
      "\"height\": 6, \"depth_scale\": 0.001}\n",
      "20 0 4\n0 20 3\n0 0 1\n",
  };
}

FuzzTarget IntrinsicsTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "camera.json", bytes);
    WriteFloats(folder / "depth.npy", Image<float>(kWidth, kHeight, 0.5f));
    FrameFiles files;
    files.image = folder / "depth.npy";
    files.intrinsics = (folder / "camera.json").string();
    RequireFrame(ReadFrameFiles(files).frame);
  };
  return {"intrinsics", run, Intrinsics};
}

}  // namespace

std::vector<FuzzTarget> FrameTargets() {
  return {
      CloudTarget("pcd", [] { return Contents{CloudPcd(false)}; }),
      CloudTarget("ply",
                  [] {
                    return Contents{CloudPly(true,
                                             "comment made by hand\nobj_info num_cols 8\nobj_info "
                                             "num_rows 6\n"),
                                    CloudPly(false, "comment width 8\ncomment height 6\n")};
                  }),
      OneFile(
          "labelled_cloud", "cloud.pcd",
          [](const fs::path& file) {
            const LabelledCloud cloud = ReadLabelledCloud(file);
            RequireFrame(cloud.frame);
            RequireLaw(cloud.labels.size() == cloud.frame.depth_m.size(), "each pixel has a label");
          },
          [] { return Contents{CloudPcd(true)}; }),
      IntrinsicsTarget(),
  };
}

}  // namespace pickbed::tests
