#include "perception/verify/image_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/math.h"

namespace pickbed::perception {
namespace {

double Excess(double value, double limit) { return std::max(0.0, value / limit - 1); }

}  // namespace

ImageDomain DomainOf(const OrganizedCloud& cloud) {
  ImageDomain domain;
  domain.hole_share = cloud.depth_statistics.hole_share;
  domain.error_at_1m_m = cloud.depth_statistics.Error_m();
  if (!cloud.planes.empty()) {
    const double down = std::abs(cloud.planes.back().normal_C.z());
    domain.tilt_rad = std::acos(std::min(1.0, down));
  }
  return domain;
}

double LogitPenalty(const ImageDomain& domain, double diameter_px) {
  constexpr double kNatsPerExcess = 2;
  return kNatsPerExcess *
         (Excess(domain.hole_share, kMaxHoleShare) +
          Excess(domain.error_at_1m_m, kMaxTrainedError_m) + Excess(domain.tilt_rad, kMaxTilt_rad) +
          Excess(kMinDiameter_px, std::max(1.0, diameter_px)));
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
