#pragma once

// Estimates the background planes of a frame without a known background: a table, or the floor and
// the walls of a bin.

#include <Eigen/Core>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

// A plane in the camera frame. Its unit normal points towards the objects; points with a negative
// signed distance are behind the plane.
struct BackgroundPlane {
  Eigen::Vector3f normal_C = Eigen::Vector3f::Zero();
  float offset_m = 0;
  float SignedDistance(const Eigen::Vector3f& p_C) const { return normal_C.dot(p_C) - offset_m; }
};

struct BackgroundOptions {
  double margin_m = 0.004;  // points this near to a plane are on it; stated at 1 m, grows with z^2
  double min_plane_share = 0.25;   // minimum share of all points on the table or floor
  double min_hidden_share = 0.03;  // the same for a plane with at most 1 % of the points behind it
  void Visit(SettingsVisitor& v);
};

// Finds the background planes from a sparse set of points. A point on or behind any returned plane
// is background.
// - Table or floor: the plane with most points (RANSAC, Fischler and Bolles 1981), if it holds
//   min_plane_share of them and does not pass through objects. Otherwise the plane with most points
//   among those with almost no points behind them.
// - Walls of an upright rectangular bin on that plane, if at least three are seen from inside.
//   A wall is a line on the floor with many points above it and almost none further out.
// - The floor of the bin itself, if it hides the table.
// Returns walls first and the table or floor last; empty if there is no table or floor. Points that
// are not finite are ignored. Deterministic. Throws InputError for options out of range.
std::vector<BackgroundPlane> FitBackground(const std::vector<Eigen::Vector3f>& points_C,
                                           const BackgroundOptions& options);

}  // namespace pickbed::perception
