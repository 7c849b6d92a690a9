#include "perception/interpenetration.h"

#include <algorithm>

namespace pickbed {
namespace {

constexpr size_t kPoints = 400;  // a part's points are even from the first on

// How deep the points of a lie in b.
float DepthIn(const ModelPoints& a, const ModelPoints& b, const Eigen::Isometry3f& X_ba) {
  float deepest_m = 0;
  const size_t count = std::min(kPoints, a.points_O.size());
  for (size_t i = 0; i < count; ++i) {
    deepest_m = std::max(deepest_m, b.distance.DepthAt(X_ba * a.points_O[i]));
  }
  return deepest_m;
}

}  // namespace

double PenetrationDepth(const ModelPoints& a, const Pose& X_Ca, const ModelPoints& b,
                        const Pose& X_Cb) {
  const Eigen::Vector3d between =
      X_Ca * a.center_O.cast<double>() - X_Cb * b.center_O.cast<double>();
  if (between.norm() > a.radius_m + b.radius_m) return 0;
  const Eigen::Isometry3f X_ba = (X_Cb.inverse(Eigen::Isometry) * X_Ca).cast<float>();
  return std::max(DepthIn(a, b, X_ba), DepthIn(b, a, X_ba.inverse(Eigen::Isometry)));
}

}  // namespace pickbed
