#pragma once

// A part as points with normals, and which of them face the camera from each of many directions, so
// that scoring and bulk ICP need no renderer.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "perception/distance_field.h"
#include "perception/surface_print.h"
#include "scenes/object_model.h"
#include "scenes/random.h"

namespace pickbed {

struct ModelPoints {
  // Even over the surface, and so is every first part of them: use the first n where fewer do.
  std::vector<Eigen::Vector3f> points_O;
  std::vector<Eigen::Vector3f> normals_O;
  std::vector<Eigen::Vector3f> directions_O;   // unit, from the part to the camera
  std::vector<std::vector<uint16_t>> visible;  // by direction: ascending indices, those
                                               // not self-occluded
  float diameter_m = 0;
  Eigen::Vector3f center_O = Eigen::Vector3f::Zero();  // of the bounding box
  float radius_m = 0;                                  // about center_O
  float area_per_point_m2 = 0;
  DistanceField distance;  // to the surface, up to 15 mm away from it
  SurfacePrint print;      // colours of points_O

  // The subset for a camera at the origin of C that sees the part at X_CO.
  const std::vector<uint16_t>& VisibleFrom(const Pose& X_CO) const;
};

// Deterministic: the samples' seed is the mesh's hash. Throws InputError when the mesh has no
// area, or for more than 65,535 points.
ModelPoints MakeModelPoints(const ObjectModel& model, int points = 1500, int directions = 200);

}  // namespace pickbed
