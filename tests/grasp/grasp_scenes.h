#pragma once

// Objects, grippers and small scenes with known grasps.

#include <numbers>

#include "grasp/grasp.h"
#include "grasp/grippers/parallel_jaw.h"
#include "scenes/base/ids.h"
#include "scenes/scene.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {

// Returns a parallel jaw with 80 mm stroke, 40 N and 20 x 50 mm pads with friction 1.
inline ParallelJaw SmallJaw() {
  ParallelJaw gripper;
  gripper.name = "test jaw";
  return gripper;
}

// Returns the pose of a hand that points straight down with its tips at `tips_W`. The closing
// direction is horizontal, at the angle `closing_rad` from x of W.
inline Pose FromAbove(const Eigen::Vector3d& tips_W, double closing_rad = 0) {
  Eigen::Matrix3d R_WG;
  R_WG.col(0) = Eigen::Vector3d(std::cos(closing_rad), std::sin(closing_rad), 0);
  R_WG.col(2) = -Eigen::Vector3d::UnitZ();
  R_WG.col(1) = R_WG.col(2).cross(R_WG.col(0));
  return MakePose(R_WG, tips_W);
}

// Returns a scene of equal boxes on the floor of the default bin, with instance ids 10, 11, ...
inline Scene BoxesOnFloor(const std::vector<Eigen::Vector2d>& places_m, double height_m) {
  Scene scene;
  for (const Eigen::Vector2d& place : places_m) {
    PosedObject instance;
    instance.instance = InstanceId(10 + static_cast<int>(scene.objects.size()));
    instance.X_WO = Translation({place.x(), place.y(), 0.5 * height_m + 0.0006});
    scene.objects.push_back(instance);
  }
  return scene;
}

// Returns a closed sphere made of rings of latitude.
inline TriangleMesh SphereMesh(double radius_m, int rings = 24) {
  const double pi = std::numbers::pi;
  const int around = 2 * rings;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, radius_m}, {0, 0, -radius_m}};
  for (int i = 1; i < rings; ++i) {
    for (int k = 0; k < around; ++k) {
      const double polar = pi * i / rings, azimuth = 2 * pi * k / around;
      mesh.vertices.push_back(radius_m * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                                         std::sin(polar) * std::sin(azimuth),
                                                         std::cos(polar)));
    }
  }
  const auto at = [&](int ring, int k) { return 2 + (ring - 1) * around + k % around; };
  for (int k = 0; k < around; ++k) {
    mesh.triangles.emplace_back(0, at(1, k), at(1, k + 1));
    mesh.triangles.emplace_back(1, at(rings - 1, k + 1), at(rings - 1, k));
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.emplace_back(at(i, k), at(i + 1, k), at(i + 1, k + 1));
      mesh.triangles.emplace_back(at(i, k), at(i + 1, k + 1), at(i, k + 1));
    }
  }
  return mesh;
}

}  // namespace pickbed::tests
