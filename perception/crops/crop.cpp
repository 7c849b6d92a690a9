#include "perception/crops/crop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::perception {

void AppendCrop(const RgbdFrame& frame, const CropSpot& spot, const Image<uint16_t>* ids,
                CropSet& crops) {
  const double z_m = spot.center_C.z();
  CheckInput(
      z_m > 0 && spot.side_m > 0,
      fmt::format("a crop of {} m at a depth of {} m: both must be above 0", spot.side_m, z_m));
  for (int row = 0; row < kCropPixels; ++row) {
    for (int column = 0; column < kCropPixels; ++column) {
      const Eigen::Vector3d offset((column + 0.5) / kCropPixels - 0.5,
                                   (row + 0.5) / kCropPixels - 0.5, 0);
      const Eigen::Vector2d uv =
          Project(frame.intrinsics, spot.center_C + spot.side_m * offset).array().round();
      const bool inside = uv.x() >= 0 && uv.y() >= 0 && uv.x() < frame.depth_m.width() &&
                          uv.y() < frame.depth_m.height();
      const int x = inside ? static_cast<int>(uv.x()) : 0,
                y = inside ? static_cast<int>(uv.y()) : 0;
      const float depth_m = inside ? frame.depth_m(x, y) : 0;
      const double relative = depth_m > 0 ? (depth_m - z_m) / spot.side_m : 1;
      crops.depth.push_back(
          static_cast<int16_t>(std::lround(kCropDepthUnit * std::clamp(relative, -1.0, 1.0))));
      crops.color.push_back(inside && !frame.color.empty() ? frame.color(x, y) : Rgb8{});
      if (ids != nullptr) crops.masks.push_back(inside && (*ids)(x, y) != 0 ? 1 : 0);
    }
  }
  crops.spots.push_back(spot);
}

void AppendRow(const CropSet& from, size_t i, CropSet& to) {
  const auto copy = [&](const auto& source, auto& target) {
    target.insert(target.end(), source.begin() + i * kCropArea,
                  source.begin() + (i + 1) * kCropArea);
  };
  copy(from.depth, to.depth);
  copy(from.color, to.color);
  if (!from.masks.empty()) copy(from.masks, to.masks);
  to.spots.push_back(from.spots[i]);
}

}  // namespace pickbed::perception
