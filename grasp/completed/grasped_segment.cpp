#include "grasp/completed/grasped_segment.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "scenes/camera/camera.h"
#include "scenes/camera/filled_depth.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// Returns the pixels whose rays may pass the box. `X_CG` is the pose of its frame in the camera.
std::optional<Eigen::AlignedBox2i> PixelsOf(const AxisAlignedBox& box_G, const Pose& X_CG,
                                            const CameraIntrinsics& k) {
  Eigen::AlignedBox2i pixels;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Vector3d p_C = X_CG * Vector3d(box_G.center + sign.cwiseProduct(box_G.half_size));
    if (p_C.z() <= 0) return std::nullopt;
    const Eigen::Vector2d uv = Project(k, p_C);
    const double u = std::clamp(uv.x(), 0.0, k.width() - 1.0);
    const double v = std::clamp(uv.y(), 0.0, k.height() - 1.0);
    pixels.extend(
        Eigen::Vector2i(static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v))));
    pixels.extend(Eigen::Vector2i(static_cast<int>(std::ceil(u)), static_cast<int>(std::ceil(v))));
  }
  return pixels;
}

}  // namespace

const SegmentMeasures* GraspedSegment(const ImageSegments& image, const PlannerInput& input,
                                      const Gripper& tool, const Pose& X_WG, double width_m) {
  if (image.segments.empty()) return nullptr;
  constexpr double kCenter_m = 0.004;  // half edge of the cube at the center of a lip
  constexpr double kMargin_m = 0.001;  // for noise of the readings
  const double opening_m = tool.OpeningOrMax_m(width_m);
  AxisAlignedBox region_G = tool.RegionBetween(opening_m).value_or(
      AxisAlignedBox{Vector3d::Zero(), Vector3d::Constant(kCenter_m)});
  region_G.half_size.array() += kMargin_m;
  const CameraIntrinsics& k = input.frame.intrinsics;
  const Pose X_CG = input.X_WC.inverse() * X_WG, X_GC = X_CG.inverse();
  const std::optional<Eigen::AlignedBox2i> pixels = PixelsOf(region_G, X_CG, k);
  if (!pixels) return nullptr;
  std::vector<int> readings(image.segments.size(), 0);
  for (int v = pixels->min().y(); v <= pixels->max().y(); ++v) {
    for (int u = pixels->min().x(); u <= pixels->max().x(); ++u) {
      const int label = image.labels(u, v);
      const float depth_m = input.frame.depth_m(u, v);
      if (label == 0 || !IsReading(depth_m)) continue;
      const Vector3d p_G = X_GC * BackProject(k, u, v, depth_m);
      if (((p_G - region_G.center).cwiseAbs() - region_G.half_size).maxCoeff() > 0) continue;
      ++readings[label - 1];
    }
  }
  const auto largest = std::max_element(readings.begin(), readings.end());
  return *largest > 0 ? &image.segments[largest - readings.begin()] : nullptr;
}

double CenterOffset_m(const SegmentMeasures& segment, const Pose& X_WC, const Pose& X_WG) {
  const Vector3d way_W = X_WC * segment.center_C - X_WG.translation();
  const Vector3d closing_W = X_WG.linear().col(0);
  return (way_W - closing_W * closing_W.dot(way_W)).head<2>().norm();
}

}  // namespace pickbed::grasp
