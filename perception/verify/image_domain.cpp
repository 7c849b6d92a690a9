#include "perception/verify/image_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenes/base/math.h"

namespace pickbed::perception {
namespace {

double Excess(double value, double limit) { return std::max(0.0, value / limit - 1); }

// Returns whether the readings on a plane are nearly as far as each other. In an image that looks
// along a floor, the farthest ones are some times as far as the nearest. The wall of a bin may be
// the only plane of an image of a full bin, and is short. So is a small table.
bool IsShort(const OrganizedCloud& cloud, const BackgroundPlane& plane) {
  constexpr float kOnPlane_m = 0.004f;  // at 1 m
  constexpr size_t kOutliers = 20;      // one in so many points at each end is ignored
  constexpr float kMaxRatio = 1.5f;     // of the distances
  std::vector<float> distances_m;
  for (const Eigen::Vector3f& p : cloud.points_C) {
    if (p.z() <= 0 || std::abs(plane.SignedDistance(p)) > kOnPlane_m * p.z() * p.z()) continue;
    distances_m.push_back(p.z());
  }
  if (distances_m.empty()) return true;
  std::ranges::sort(distances_m);
  const size_t ignored = distances_m.size() / kOutliers;
  return distances_m[distances_m.size() - 1 - ignored] < kMaxRatio * distances_m[ignored];
}

}  // namespace

ImageDomain DomainOf(const OrganizedCloud& cloud) {
  ImageDomain domain;
  domain.hole_share = cloud.depth_statistics.hole_share;
  domain.error_at_1m_m = cloud.depth_statistics.Error_m();
  if (cloud.background != BackgroundKind::kKnown) domain.min_diameter_px = kMinRoomDiameter_px;
  if (!cloud.planes.empty()) {
    const double down = std::abs(cloud.planes.back().normal_C.z());
    domain.tilt_rad = std::acos(std::min(1.0, down));
    if (domain.tilt_rad > kMaxTilt_rad && cloud.background == BackgroundKind::kFitted &&
        IsShort(cloud, cloud.planes.back())) {
      domain.tilt_rad = 0;
    }
  }
  return domain;
}

double OutsideShare(const CameraIntrinsics& camera, const ModelPoints& model, const Pose& X_CO) {
  const auto is_outside = [&](const Eigen::Vector3d& p_C, double margin_px) {
    if (p_C.z() <= 0) return true;
    const Eigen::Vector2d px = Project(camera, p_C);
    return px.x() < margin_px - 0.5 || px.x() >= camera.width() - 0.5 - margin_px ||
           px.y() < margin_px - 0.5 || px.y() >= camera.height() - 0.5 - margin_px;
  };
  // Most objects are far from the edge of the image. For them, a bound on the projection of the
  // bounding ball is enough. It holds up to 60 degrees from the optical axis.
  const Eigen::Vector3d center_C = X_CO * model.center_O.cast<double>();
  const double near_m = center_C.z() - model.radius_m;
  const double ball_px = std::max(camera.fx(), camera.fy()) * 2 * model.radius_m / near_m;
  if (near_m > 0 && !is_outside(center_C, ball_px)) return 0;
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  if (visible.empty()) return 0;
  const auto outside = std::count_if(visible.begin(), visible.end(), [&](uint16_t i) {
    return is_outside(X_CO * model.points_O[i].cast<double>(), 0);
  });
  return static_cast<double>(outside) / static_cast<double>(visible.size());
}

double DiameterInImage_px(const CameraIntrinsics& camera, double diameter_m, const Pose& X_CO) {
  constexpr double kNearest_m = 1e-3;
  return camera.fx() * diameter_m / std::max(kNearest_m, X_CO.translation().z());
}

double LogitPenalty(const ImageDomain& domain, double diameter_px, double outside_share) {
  constexpr double kNatsPerExcess = 2;
  return kNatsPerExcess *
         (Excess(domain.hole_share, kMaxHoleShare) +
          Excess(domain.error_at_1m_m, kMaxTrainedError_m) + Excess(domain.tilt_rad, kMaxTilt_rad) +
          Excess(domain.min_diameter_px, std::max(1.0, diameter_px)) +
          Excess(outside_share, kMaxOutsideShare));
}

std::vector<std::string> DomainWarnings(const ImageDomain& domain) {
  std::vector<std::string> warnings;
  if (domain.hole_share > kMaxHoleShare) {
    warnings.push_back(
        fmt::format("{:.0f} % of the depth is missing, more than the {:.0f} % of the "
                    "training: scores are lowered",
                    100 * domain.hole_share, 100 * kMaxHoleShare));
  }
  if (domain.error_at_1m_m > kMaxTrainedError_m) {
    warnings.push_back(
        fmt::format("the depth has a noise of {:.1f} mm at 1 m, more than the {:.1f} "
                    "mm of the training: scores are lowered",
                    1e3 * domain.error_at_1m_m, 1e3 * kMaxTrainedError_m));
  }
  if (domain.tilt_rad > kMaxTilt_rad) {
    warnings.push_back(
        fmt::format("the camera looks {:.0f} degrees from the vertical of the floor, "
                    "more than the {:.0f} of the training: scores are lowered",
                    Degrees(domain.tilt_rad), Degrees(kMaxTilt_rad)));
  }
  return warnings;
}

}  // namespace pickbed::perception
