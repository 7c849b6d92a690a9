#pragma once

// Exact point clouds of simple surfaces.

#include <cmath>

#include "perception/cloud/organized_cloud.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Returns the cloud of a surface in C. surface(ray) returns {distance along the ray with z = 1, or
// 0 for no hit, normal}.
template <typename Surface>
OrganizedCloud AnalyticCloud(Surface surface) {
  OrganizedCloud cloud;
  const CameraIntrinsics& k = cloud.intrinsics;
  cloud.depth_m = Image<float>(k.width(), k.height());
  cloud.foreground = Image<uint8_t>(k.width(), k.height());
  cloud.points_C.assign(cloud.depth_m.size(), Eigen::Vector3f::Zero());
  cloud.normals_C.assign(cloud.depth_m.size(), Eigen::Vector3f::Zero());
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      const Eigen::Vector3d ray = BackProject(k, x, y, 1.0);
      const auto [t, normal] = surface(ray);
      if (!(t > 0)) continue;
      const int pixel = y * k.width() + x;
      cloud.depth_m(x, y) = static_cast<float>(t);
      cloud.points_C[pixel] = (t * ray).template cast<float>();
      cloud.normals_C[pixel] = normal.template cast<float>();
      cloud.foreground(x, y) = 1;
      cloud.foreground_pixels.push_back(pixel);
    }
  }
  return cloud;
}

struct SurfacePoint {
  double t = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

// Returns the plane through (0, 0, depth_m). The unit normal points to the camera.
inline OrganizedCloud PlaneCloud(double depth_m, const Eigen::Vector3d& normal) {
  return AnalyticCloud([&](const Eigen::Vector3d& ray) {
    return SurfacePoint{normal.z() * depth_m / normal.dot(ray), normal};
  });
}

// Returns a sphere on the optical axis, with its nearest point at depth_m.
inline OrganizedCloud SphereCloud(double depth_m, double radius_m) {
  const Eigen::Vector3d center(0, 0, depth_m + radius_m);
  return AnalyticCloud([&](const Eigen::Vector3d& ray) {
    const double b = ray.dot(center) / ray.squaredNorm();
    const double c = (center.squaredNorm() - radius_m * radius_m) / ray.squaredNorm();
    if (b * b < c) return SurfacePoint{};
    const double t = b - std::sqrt(b * b - c);
    return SurfacePoint{t, (t * ray - center) / radius_m};
  });
}

// Returns the index of the pixel to the right of and below the optical axis.
inline int CenterPixel(const OrganizedCloud& cloud) {
  const CameraIntrinsics& k = cloud.intrinsics;
  return static_cast<int>(k.cy() + 0.5) * k.width() + static_cast<int>(k.cx() + 0.5);
}

}  // namespace pickbed::tests
