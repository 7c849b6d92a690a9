#include "perception/features/patch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr int8_t kFar = 127;
constexpr float kBrightest = 255;  // maximum of a color channel

// Pixel index of each grid point of the patch, -1 = outside the image. The grid is in the plane z =
// 0 of P. Its projection is a homography, evaluated row by row in plain arrays so that the compiler
// can use vector instructions.
using GridPixels = std::array<int, kPatchArea>;

void ProjectGrid(const CameraIntrinsics& k, const Eigen::Matrix3f& R_CP, const Eigen::Vector3f& p_C,
                 float side, GridPixels& pixels) {
  const float step = side / kPatchPixels;
  const float first = -0.5f * side + 0.5f * step;
  const Eigen::Vector3f ex = R_CP.col(0) * step;
  const float fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  // + 1.5 here and - 1 below: rounds to nearest and separates -1 from 0 under truncation.
  const float cx = static_cast<float>(k.cx()) + 1.5f, cy = static_cast<float>(k.cy()) + 1.5f;
  const float width = static_cast<float>(k.width()), height = static_cast<float>(k.height());
  for (int row = 0; row < kPatchPixels; ++row) {
    const Eigen::Vector3f start =
        p_C + R_CP.col(0) * first + R_CP.col(1) * (first + static_cast<float>(row) * step);
    int* out = pixels.data() + row * kPatchPixels;
    for (int col = 0; col < kPatchPixels; ++col) {
      const float t = static_cast<float>(col);
      const float inverse_z = 1.0f / (start.z() + t * ex.z());
      const float u = fx * (start.x() + t * ex.x()) * inverse_z + cx;
      const float v = fy * (start.y() + t * ex.y()) * inverse_z + cy;
      const bool inside = u >= 1.0f && u < width + 1.0f && v >= 1.0f && v < height + 1.0f;
      const float column = inside ? u : 1.0f, line = inside ? v : 1.0f;
      const int index = (static_cast<int>(line) - 1) * k.width() + static_cast<int>(column) - 1;
      out[col] = inside ? index : -1;
    }
  }
}

int8_t Quantized(float value) {
  const float clipped = std::clamp(value, -1.0f, 1.0f);
  return static_cast<int8_t>(static_cast<int>(clipped * 127.0f + 127.5f) - 127);
}

Eigen::Vector3f ColorValue(Rgb8 color) {
  const Eigen::Vector3f bytes(color.r, color.g, color.b);
  return bytes * (2 / kBrightest) - Eigen::Vector3f::Ones();
}

// Writes the four channels; value_of(pixel) returns channels 1 to 3.
template <typename ValueOf>
void FillPatch(const OrganizedCloud& cloud, const GridPixels& pixels, const Eigen::Matrix3f& R_CP,
               const Eigen::Vector3f& p_C, float side, const ValueOf& value_of, int8_t* out) {
  const Eigen::Vector3f depth_row = R_CP.col(2) * (2.0f / side);
  const float depth_offset = depth_row.dot(p_C);
  const uint8_t* foreground = cloud.foreground.data();
  for (int i = 0; i < kPatchArea; ++i) {
    const int pixel = pixels[i];
    if (pixel < 0 || !foreground[pixel]) {
      out[i] = kFar;
      out[i + kPatchArea] = out[i + 2 * kPatchArea] = out[i + 3 * kPatchArea] = 0;
      continue;
    }
    const Eigen::Vector3f value = value_of(pixel);
    out[i] = Quantized(depth_row.dot(cloud.points_C[pixel]) - depth_offset);
    out[i + kPatchArea] = Quantized(value.x());
    out[i + 2 * kPatchArea] = Quantized(value.y());
    out[i + 3 * kPatchArea] = Quantized(value.z());
  }
}

}  // namespace

const char* NameOf(PatchChannels channels) {
  return channels == PatchChannels::kDepthColor ? "depth and color" : "depth and normals";
}

double PatchSide(double diameter_m, double patch_diameters) {
  CheckInput(diameter_m > 0 && patch_diameters > 0,
             "a patch needs an object with a positive diameter");
  const double steps = std::round(2.0 * std::log2(diameter_m * patch_diameters / 1e-3));
  return 1e-3 * std::exp2(0.5 * steps);
}

Pose PatchFrame(const Eigen::Vector3d& point_C, double angle_rad) {
  const Eigen::Vector3d z = point_C.normalized();
  const Eigen::Vector3d y0 = z.cross(Eigen::Vector3d::UnitX()).normalized();
  const Eigen::Vector3d x0 = y0.cross(z);
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Eigen::Matrix3d R_CP;
  R_CP << c * x0 + s * y0, c * y0 - s * x0, z;
  return MakePose(R_CP, point_C);
}

void RequireChannels(const OrganizedCloud& cloud, PatchChannels channels) {
  if (channels != PatchChannels::kDepthColor) return;
  CheckInput(!cloud.color.empty(),
             "the network was trained on depth and color, but the frame has no color image; give "
             "it one or use a model with network.autoencoder.channels depth_normals");
}

PatchSet CutPatches(const OrganizedCloud& cloud, std::span<const int> pixels,
                    std::span<const double> angles_rad, const PatchForm& form) {
  RequireChannels(cloud, form.channels);
  PatchSet set;
  set.values.resize(pixels.size() * kPatchValues);
  set.X_CP.reserve(pixels.size());
  const float side = static_cast<float>(form.side_m);
  GridPixels grid;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector3f& p_C = cloud.points_C[pixels[i]];
    set.X_CP.push_back(PatchFrame(p_C.cast<double>(), angles_rad[i]));
    const Eigen::Matrix3f R_CP = set.X_CP.back().linear().cast<float>();
    ProjectGrid(cloud.intrinsics, R_CP, p_C, side, grid);
    int8_t* out = set.values.data() + i * kPatchValues;
    if (form.channels == PatchChannels::kDepthColor) {
      FillPatch(
          cloud, grid, R_CP, p_C, side,
          [&](int pixel) { return ColorValue(cloud.color.data()[pixel]); }, out);
    } else {
      const Eigen::Matrix3f R_PC = R_CP.transpose();
      FillPatch(
          cloud, grid, R_CP, p_C, side,
          [&](int pixel) -> Eigen::Vector3f { return R_PC * cloud.normals_C[pixel]; }, out);
    }
  }
  return set;
}

bool IsUnknownAt(std::span<const int8_t> patch, int pixel) {
  return patch[pixel] == kFar && patch[pixel + kPatchArea] == 0 &&
         patch[pixel + 2 * kPatchArea] == 0 && patch[pixel + 3 * kPatchArea] == 0;
}

Rgb8 PatchColorAt(std::span<const int8_t> patch, int pixel) {
  const auto byte = [&](int channel) {
    const float value = patch[channel * kPatchArea + pixel] / 127.0f;
    return static_cast<uint8_t>(std::lround(0.5f * kBrightest * (value + 1)));
  };
  return {byte(1), byte(2), byte(3)};
}

}  // namespace pickbed::perception
