#include "sim/hands/suction_seal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/geometry/decompositions.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3d;

Vector3d OnRing(double radius_m, int index, int count, double z_m) {
  const double angle = 2 * std::numbers::pi * index / count;
  return {radius_m * std::cos(angle), radius_m * std::sin(angle), z_m};
}

bool HasHole(const MeshQuery& mesh_O, const Pose& X_OG, const CupSpec& spec,
             const SealOptions& options) {
  const auto goes_through = [&](double radius_m, int index) {
    constexpr double kFar_m = 10;  // beyond any object
    const Vector3d start = OnRing(radius_m, index, options.inner_rays, -spec.bellows_travel_m);
    return !mesh_O.Raycast(X_OG * start, X_OG.linear().col(2), 0, kFar_m);
  };
  if (goes_through(0, 0)) return true;
  for (const double share : options.inner_rings) {
    for (int i = 0; i < options.inner_rays; ++i) {
      if (goes_through(share * spec.radius_m, i)) return true;
    }
  }
  return false;
}

}  // namespace

CupSeal TestSeal(const MeshQuery& mesh_O, const Pose& X_OG, const CupSpec& spec,
                 const SealOptions& options) {
  const int rays = options.rim_rays;
  CupSeal seal;
  const double range_m = spec.bellows_travel_m + options.reach_beyond_m;
  Eigen::Matrix<double, Eigen::Dynamic, 3> plane(rays, 3);  // rows of z = a x + b y + c
  Eigen::VectorXd z(rays);
  int hits = 0;
  bool too_far = false;
  double pressed_m = 0;
  for (int i = 0; i < rays; ++i) {
    const Vector3d start = OnRing(spec.radius_m, i, rays, -spec.bellows_travel_m);
    // A ray that starts inside the object leaves it before it enters it.
    const auto hit = mesh_O.Raycast(X_OG * start, X_OG.linear().col(2), 0, range_m);
    if (!hit) continue;
    too_far |= hit->normal.dot(X_OG.linear().col(2)) > 0;
    plane.row(hits) << start.x(), start.y(), 1;
    z[hits] = start.z() + hit->distance;
    const double depth_m = std::max(0.0, -z[hits]);
    pressed_m += depth_m;
    seal.press_center_m += depth_m * start.head<2>();
    ++hits;
  }
  seal.touching = static_cast<double>(hits) / rays;
  if (hits == 0) return seal;
  seal.compression_m = pressed_m / rays;
  if (pressed_m > 0) seal.press_center_m /= pressed_m;
  if (too_far) seal.fault = SealFault::kTooFar;
  if (too_far || hits < rays) return seal;

  const Vector3d fit = MinimumNormSolution(plane, z);
  seal.uneven_m = (z - plane * fit).cwiseAbs().maxCoeff();
  seal.tilt_rad = std::atan(fit.head<2>().norm());
  if (seal.uneven_m > spec.lip_conform_m) {
    seal.fault = SealFault::kUneven;
  } else if (HasHole(mesh_O, X_OG, spec, options)) {
    seal.fault = SealFault::kLeaks;
  } else {
    seal.fault = SealFault::kNone;
  }
  return seal;
}

}  // namespace pickbed::sim
