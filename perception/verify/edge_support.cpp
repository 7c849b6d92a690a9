#include "perception/verify/edge_support.h"

#include <algorithm>
#include <cmath>

namespace pickbed::perception {
namespace {

// Returns the pixel that is nearest to the image of p_C. It is outside every image if the image of
// p_C is far outside, where pixels do not fit into an integer, or is no number.
Eigen::Vector2i NearestPixel(const CameraIntrinsics& k, const Eigen::Vector3f& p_C) {
  const auto nearest = [](double px) {
    if (!std::isfinite(px)) return -1;
    return static_cast<int>(std::lround(std::clamp<double>(px, -1, CameraIntrinsics::kMaxSize_px)));
  };
  const Eigen::Vector2d at_px = Project(k, p_C.cast<double>());
  return {nearest(at_px.x()), nearest(at_px.y())};
}

}  // namespace

EdgeSupport MeasureEdgeSupport(const OrganizedCloud& cloud, const ModelPoints& model,
                               const Pose& X_CO) {
  constexpr float kInFrontAt1m = 0.006f;  // a reading this much nearer hides the point
  EdgeSupport support;
  const ColorEdges& edges = cloud.edges;
  if (edges.empty()) return support;
  const Eigen::Matrix3f R_CO = X_CO.linear().cast<float>();
  const Eigen::Vector3f t_C = X_CO.translation().cast<float>();
  const CameraIntrinsics &k = edges.intrinsics, &kd = cloud.intrinsics;
  const float fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  double sum = 0;
  for (const EdgePoint& point : model.edges) {
    const Eigen::Vector3f p_C = R_CO * point.p_O + t_C;
    if (p_C.z() <= 0) continue;
    if (p_C.dot(R_CO * point.normal_1_O) >= 0 && p_C.dot(R_CO * point.normal_2_O) >= 0) continue;
    const Eigen::Vector2i at_px = NearestPixel(k, p_C);
    const int u = at_px.x(), v = at_px.y();
    if (!edges.du.Contains(u, v)) continue;
    const Eigen::Vector2i depth_px = NearestPixel(kd, p_C);
    if (cloud.depth_m.Contains(depth_px.x(), depth_px.y())) {
      const float z_m = cloud.depth_m(depth_px.x(), depth_px.y());
      if (z_m > 0 && z_m < p_C.z() - kInFrontAt1m * p_C.z() * p_C.z()) continue;
    }
    // Direction of the edge in the image.
    const Eigen::Vector3f along_C = R_CO * point.along_O;
    const float line_u = fx * (along_C.x() * p_C.z() - p_C.x() * along_C.z());
    const float line_v = fy * (along_C.y() * p_C.z() - p_C.y() * along_C.z());
    const float length = std::hypot(line_u, line_v);
    if (!(length > 0)) continue;
    const float across = (edges.dv(u, v) * line_u - edges.du(u, v) * line_v) / length;
    sum += std::min(kMaxGradient, std::abs(across));
    ++support.visible;
  }
  if (support.visible > 0) support.mean = sum / support.visible;
  return support;
}

}  // namespace pickbed::perception
