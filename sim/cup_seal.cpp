#include "sim/cup_seal.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace pickbed {
namespace {

using Eigen::Vector3d;

// 3 mm apart on a lip of 15 mm radius: finer than the features that a lip cannot close.
constexpr int kRimRays = 32;
// Rings inside the rim, as shares of its radius, on which holes are looked for.
constexpr std::array<double, 3> kInnerRings{0.0, 0.4, 0.75};
constexpr int kInnerRays = 12;
// A lip clings to what it just misses: this much beyond its uncompressed end.
constexpr double kReachBeyond_m = 0.0002;

Vector3d OnRing(double radius_m, int index, int count, double z_m) {
  const double angle = 2 * std::numbers::pi * index / count;
  return {radius_m * std::cos(angle), radius_m * std::sin(angle), z_m};
}

// z of G of the first surface along the approach from `start_G` on; infinite when there is none.
double SurfaceZ(const MeshQuery& mesh_O, const Pose& X_OG, const Vector3d& start_G,
                double range_m) {
  const auto hit = mesh_O.Raycast(X_OG * start_G, X_OG.linear().col(2), 0, range_m);
  return hit ? start_G.z() + hit->distance : std::numeric_limits<double>::infinity();
}

bool HasHole(const MeshQuery& mesh_O, const Pose& X_OG, const CupSpec& spec) {
  constexpr double kFar_m = 10;  // beyond any part
  for (const double share : kInnerRings) {
    const int count = share == 0 ? 1 : kInnerRays;
    for (int i = 0; i < count; ++i) {
      const Vector3d start = OnRing(share * spec.radius_m, i, count, -spec.bellows_travel_m);
      if (!std::isfinite(SurfaceZ(mesh_O, X_OG, start, kFar_m))) return true;
    }
  }
  return false;
}

}  // namespace

const char* SealFaultName(SealFault fault) {
  switch (fault) {
    case SealFault::kNone:
      return "sealed";
    case SealFault::kMissed:
      return "the rim misses the surface";
    case SealFault::kTooFar:
      return "the stem would meet the part";
    case SealFault::kUneven:
      return "the surface is uneven under the lip";
    case SealFault::kLeaks:
      return "a hole inside the rim";
  }
  return "";
}

CupSeal TestSeal(const MeshQuery& mesh_O, const Pose& X_OG, const CupSpec& spec) {
  CupSeal seal;
  const double range_m = spec.bellows_travel_m + kReachBeyond_m;
  Eigen::Matrix<double, kRimRays, 3> plane;  // z = a x + b y + c
  Eigen::Matrix<double, kRimRays, 1> z;
  int hits = 0;
  bool too_far = false;
  double pressed_m = 0;
  for (int i = 0; i < kRimRays; ++i) {
    const Vector3d start = OnRing(spec.radius_m, i, kRimRays, -spec.bellows_travel_m);
    // Starting from within the part there is a way out before there is a way in.
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
  seal.touching = static_cast<double>(hits) / kRimRays;
  if (hits == 0) return seal;
  seal.compression_m = pressed_m / kRimRays;
  if (pressed_m > 0) seal.press_center_m /= pressed_m;
  if (too_far) seal.fault = SealFault::kTooFar;
  if (too_far || hits < kRimRays) return seal;

  const Vector3d fit = plane.colPivHouseholderQr().solve(z);
  seal.uneven_m = (z - plane * fit).cwiseAbs().maxCoeff();
  seal.tilt_rad = std::atan(fit.head<2>().norm());
  if (seal.uneven_m > spec.lip_conform_m) {
    seal.fault = SealFault::kUneven;
  } else if (HasHole(mesh_O, X_OG, spec)) {
    seal.fault = SealFault::kLeaks;
  } else {
    seal.fault = SealFault::kNone;
  }
  return seal;
}

}  // namespace pickbed
