#pragma once

// Table, or floor and walls of a bin, found in a frame whose background nobody told.

#include <Eigen/Core>
#include <vector>

namespace pickbed {

// Unit normal towards the parts; points with a negative distance are behind the plane.
struct BackgroundPlane {
  Eigen::Vector3f normal_C = Eigen::Vector3f::Zero();
  float offset_m = 0;
  float SignedDistance(const Eigen::Vector3f& p_C) const { return normal_C.dot(p_C) - offset_m; }
};

struct BackgroundOptions {
  double margin_m = 0.004;         // points this near to a plane are on it, at 1 m; grows with z^2
  double min_plane_share = 0.25;   // of the points, on a table or floor
  double min_hidden_share = 0.03;  // enough where next to nothing lies behind the plane
};

// First the table or floor: the plane of most points (RANSAC, Fischler and Bolles 1981), if it
// holds enough of them, else the one of most points with next to nothing behind it. Then the walls
// of an upright rectangular bin on it, if three at least are seen from inside: places beside which
// next to nothing lies further out, and at which points stand over one line of the floor; and the
// bin's own floor, where that hides the table. What is on or behind any of the planes is
// background. The table or floor is the last; empty where nothing is found. The same points give
// the same planes.
std::vector<BackgroundPlane> FitBackground(const std::vector<Eigen::Vector3f>& points_C,
                                           const BackgroundOptions& options);

}  // namespace pickbed
