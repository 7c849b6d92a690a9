#pragma once

// An object as surface points with normals. The visible points are precomputed for many viewing
// directions, so that scoring and bulk ICP need no renderer.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/distance_field.h"
#include "perception/model/edge_points.h"
#include "perception/model/surface_texture.h"
#include "scenes/base/random.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

// Surface points of one object with precomputed visibility, distance field and colors.
struct ModelPoints {
  // Evenly spread over the surface. The first n points are also even for every n, so a caller that
  // needs fewer points uses the first n.
  std::vector<Eigen::Vector3f> points_O;
  std::vector<Eigen::Vector3f> normals_O;
  std::vector<Eigen::Vector3f> directions_O;   // unit, from the object to the camera
  std::vector<std::vector<uint16_t>> visible;  // per direction: ascending indices of the points
                                               // that face the camera without self-occlusion
  float diameter_m = 0;
  Eigen::Vector3f center_O = Eigen::Vector3f::Zero();  // center of the bounding box
  float radius_m = 0;                                  // of the bounding ball about center_O
  float area_per_point_m2 = 0;
  DistanceField distance;  // distance to the surface, up to 15 mm away from it
  SurfaceTexture texture;  // colors of points_O
  std::vector<EdgePoint> edges;

  // Returns the visible points of an object at X_CO, for the nearest of the viewing directions.
  const std::vector<uint16_t>& VisibleFrom(const Pose& X_CO) const;
};

// Samples the surface and computes visibility. Deterministic: the mesh hash is the seed. Throws
// InputError if the mesh has no area, for fewer than 1 or more than 65,535 points, and for no
// directions.
ModelPoints MakeModelPoints(const ObjectModel& model, int points = 1500, int directions = 200);

// A model point that is visible in the image, where model and image colors can be compared.
struct SeenPoint {
  int point = 0;  // index into ModelPoints::points_O
  int pixel = 0;  // index into the image, row by row
};

// Returns the first 400 visible points that face the camera and have a reading on their surface.
std::vector<SeenPoint> SeenPoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                  const Pose& X_CO);

}  // namespace pickbed::perception
