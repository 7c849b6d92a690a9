#pragma once

// Model points of an ICP, moved to a pose and projected to pixels, several points at a time. Each
// operation is rounded as in the same code for one point, so the results are the same on every
// x86-64 CPU.

#include <array>

#include "perception/icp/normal_equations.h"
#include "scenes/camera/camera.h"

namespace pickbed::perception {

inline constexpr int kMaxIcpPoints = 512;  // a multiple of the vector width

// One value per point, for each of x, y and z.
using PointArray = std::array<std::array<float, kMaxIcpPoints>, 3>;

// Returns element i as a vector.
inline Eigen::Vector3f At(const PointArray& values, int i) {
  return {values[0][i], values[1][i], values[2][i]};
}

// Points on the surface and their normals, in the object frame, relative to the object center.
// Values after the last point are unspecified.
struct IcpPoints {
  int count = 0;
  PointArray points = {}, normals = {};
};

// The same points at a pose.
struct ProjectedPoints {
  PointArray arms;  // from the object center to the point, in C
  PointArray points_C, normals_C;
  std::array<int, kMaxIcpPoints> pixels;  // row-major; -1 outside the image or behind the camera
};

// Moves the points (m, in O) to `pose` and projects them with rounding to the nearest pixel, as
// Projector does. The result is in C. Its first `count` elements are valid. `count` is at most
// kMaxIcpPoints.
void ProjectPoints(const IcpPoints& points, const CenteredPose& pose,
                   const CameraIntrinsics& camera, ProjectedPoints& projected);

}  // namespace pickbed::perception
