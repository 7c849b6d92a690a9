#include "eval/draw/bin_view.h"

#include <algorithm>
#include <cmath>

#include "scenes/camera/footprint.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::eval {

ImageBox BinRegion(const Camera& camera, const Bin& bin) {
  constexpr double kMargin = 0.07;  // of the larger side of the bin
  const CameraIntrinsics& k = camera.intrinsics;
  const ImageBox whole{0, 0, k.width(), k.height()};
  const Footprint footprint = FootprintOf(MeshBounds(BinMesh(bin)), camera.X_CW(), k);
  if (!footprint.in_front || !footprint.Overlaps(k)) return whole;
  const Eigen::Vector2d size_px = footprint.max_px - footprint.min_px;
  const double margin_px = kMargin * size_px.maxCoeff();
  const auto column = [&](double x) {
    return std::clamp(static_cast<int>(std::lround(x)), 0, k.width() - 1);
  };
  const auto row = [&](double y) {
    return std::clamp(static_cast<int>(std::lround(y)), 0, k.height() - 1);
  };
  const int left = column(footprint.min_px.x() - margin_px);
  const int top = row(footprint.min_px.y() - margin_px);
  return {left, top, column(footprint.max_px.x() + margin_px) - left + 1,
          row(footprint.max_px.y() + margin_px) - top + 1};
}

Camera WindowOf(const Camera& camera, const ImageBox& region, int width_px) {
  const CameraIntrinsics& k = camera.intrinsics;
  const double scale = static_cast<double>(width_px) / region.width;
  const int height_px = std::max(1, static_cast<int>(std::lround(scale * region.height)));
  return {{width_px, height_px, scale * k.fx(), scale * k.fy(),
           scale * (k.cx() - region.x + 0.5) - 0.5, scale * (k.cy() - region.y + 0.5) - 0.5},
          camera.X_WC()};
}

Camera BinCamera(const Camera& camera, const Bin& bin) {
  constexpr int kMaxWidth_px = 1600;
  const ImageBox region = BinRegion(camera, bin);
  return WindowOf(camera, region, std::min(2 * region.width, kMaxWidth_px));
}

CameraIntrinsics EnlargedBy(const CameraIntrinsics& k, int factor) {
  return {k.width() * factor, k.height() * factor,           k.fx() * factor,
          k.fy() * factor,    (k.cx() + 0.5) * factor - 0.5, (k.cy() + 0.5) * factor - 0.5};
}

}  // namespace pickbed::eval
