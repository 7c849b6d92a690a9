#pragma once

// Parts, grippers and small scenes with known grasps.

#include <numbers>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/scene.h"
#include "tests/sim/physics_parts.h"

namespace pickbed {

// 80 mm stroke, 40 N, 20 x 50 mm pads of friction 1.
inline GripperSpec SmallJaw() {
  GripperSpec gripper;
  gripper.name = "test jaw";
  return gripper;
}

// A hand that comes straight down on the point where its tips are to be, closing along a direction
// of the floor plan, measured from x of W.
inline Pose FromAbove(const Eigen::Vector3d& tips_W, double closing_rad = 0) {
  Eigen::Matrix3d R_WG;
  R_WG.col(0) = Eigen::Vector3d(std::cos(closing_rad), std::sin(closing_rad), 0);
  R_WG.col(2) = -Eigen::Vector3d::UnitZ();
  R_WG.col(1) = R_WG.col(2).cross(R_WG.col(0));
  return MakePose(R_WG, tips_W);
}

// Boxes of one kind that stand on the floor of the default bin, instance ids 10, 11, ...
inline Scene BoxesOnFloor(const std::vector<Eigen::Vector2d>& places_m, double height_m) {
  Scene scene;
  for (const Eigen::Vector2d& place : places_m) {
    PosedObject part;
    part.instance = 10 + static_cast<int>(scene.objects.size());
    part.X_WO = Translation({place.x(), place.y(), 0.5 * height_m + 0.0006});
    scene.objects.push_back(part);
  }
  return scene;
}

// Sphere by rings of latitude, closed.
inline TriangleMesh SphereMesh(double radius_m, int rings = 24) {
  const double pi = std::numbers::pi;
  const int around = 2 * rings;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, radius_m}, {0, 0, -radius_m}};
  for (int i = 1; i < rings; ++i) {
    for (int k = 0; k < around; ++k) {
      const double polar = pi * i / rings, turn = 2 * pi * k / around;
      mesh.vertices.push_back(radius_m * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                                         std::sin(polar) * std::sin(turn),
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

}  // namespace pickbed
