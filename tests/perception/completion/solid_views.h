#pragma once

// Solids with known distances, and ideal views of them, for the tests of shape completion.

#include <memory>

#include "perception/completion/random_view.h"
#include "perception/completion/traced_solid.h"

namespace pickbed::perception {

inline std::unique_ptr<ViewedSolid> SphereSolid(float radius_m) {
  return std::make_unique<TracedSolid>(
      [radius_m](std::span<const Eigen::Vector3f> points_O, std::span<float> distances_m) {
        for (size_t i = 0; i < points_O.size(); ++i) {
          distances_m[i] = points_O[i].norm() - radius_m;
        }
      },
      Eigen::AlignedBox3f(Eigen::Vector3f::Constant(-radius_m),
                          Eigen::Vector3f::Constant(radius_m)));
}

// The depth (m) of a sphere around center_C at a pixel, by the quadratic equation; 0 = misses.
inline double SphereDepth_m(const CameraIntrinsics& k, int x, int y,
                            const Eigen::Vector3d& center_C, double radius_m) {
  const Eigen::Vector3d ray_C = BackProject(k, x, y, 1);
  const double a = ray_C.squaredNorm(), b = ray_C.dot(center_C);
  const double c = center_C.squaredNorm() - radius_m * radius_m;
  const double root = b * b - a * c;
  return root < 0 ? 0 : (b - std::sqrt(root)) / a;
}

// An ideal view of a sphere before a wall. The segment shows the sphere.
inline SegmentView SphereView(const CameraIntrinsics& k, const Eigen::Vector3d& center_C,
                              double radius_m, float wall_m) {
  SegmentView view;
  view.intrinsics = k;
  view.depth_m = Image<float>(k.width(), k.height(), wall_m);
  view.segment = Image<uint8_t>(k.width(), k.height(), 0);
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      const double z_m = SphereDepth_m(k, x, y, center_C, radius_m);
      if (z_m <= 0) continue;
      view.depth_m(x, y) = static_cast<float>(z_m);
      view.segment(x, y) = 1;
    }
  }
  return view;
}

inline CameraIntrinsics TestCamera() { return {160, 120, 400, 400, 79.5, 59.5}; }
inline const Eigen::Vector3d kSphereCenter_C(0.03, -0.02, 0.6);
inline constexpr double kSphereRadius_m = 0.04;

inline SegmentView UsualSphereView(float wall_m = 0.9f) {
  return SphereView(TestCamera(), kSphereCenter_C, kSphereRadius_m, wall_m);
}

}  // namespace pickbed::perception
