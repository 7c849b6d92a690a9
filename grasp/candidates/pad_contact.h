#pragma once

// Geometric contact of the pads of a parallel jaw with a single object, without physics: the
// opening at which the pads stop, the contact area, and the clearance of the rest of the hand.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "grasp/layer.h"
#include "scenes/base/random.h"
#include "scenes/objects/object_model.h"
#include "sim/hands/jaw_hand.h"

namespace pickbed::grasp {

// One point per row. Single precision, stored by column, because ten thousands of candidates are
// tested.
using PointColumns = Eigen::Array<float, Eigen::Dynamic, 3>;

// Surface of an object as points with uniform density.
struct SurfacePoints {
  PointColumns points_O;
  PointColumns normals_O;
  double area_m2 = 0;  // area per point
};

// Samples about one point per `spacing_m` squared, limited to min_count..max_count.
SurfacePoints SpreadPoints(const TriangleMesh& mesh, double spacing_m, int min_count, int max_count,
                           Rng& rng);

// Rotates the points into the axes of G; the origin stays at O. All hands with the same orientation
// can share the result.
PointColumns Rotated(const PointColumns& points_O, const Eigen::Matrix3d& R_OG);

// Result of closing the pads; distances and positions are in G.
struct PadContact {
  bool touches = false;  // both pads meet surface that faces them
  double low_x_m = 0;    // where the two pads stop, along x of G
  double high_x_m = 0;
  double area_m2 = 0;        // of the smaller of the two contacts
  double max_angle_rad = 0;  // larger angle of a mean contact normal to x
  // Rectangle in (y, z) of G where both pads are in contact; empty if min > max.
  Eigen::Vector2d shared_min = Eigen::Vector2d::Zero();
  Eigen::Vector2d shared_max = Eigen::Vector2d::Zero();

  double width_m() const { return high_x_m - low_x_m; }
  bool shared() const { return (shared_max.array() >= shared_min.array()).all(); }
  Eigen::Vector2d shared_center() const { return 0.5 * (shared_min + shared_max); }
};

// Contact points of one pad in G, and the mean surface normal there.
struct PadPatch {
  std::vector<Eigen::Vector3d> points_G;
  Eigen::Vector3d normal_G = Eigen::Vector3d::Zero();  // unit, out of the object
};

// Returns the opening on the approach to an object of this width: the width and the clearance on
// each side. Returns nullopt beyond the stroke.
std::optional<double> JawOpening_m(const HandSpec& hand, double clearance_m, double width_m);

// Closes the pads of `hand` at X_OG on the object. `turned`: the surface points rotated by R_OG.
// Surface within `band_m` of the first touch counts as contact.
PadContact ClosePads(const SurfacePoints& surface, const PointColumns& turned, const Pose& X_OG,
                     const HandSpec& hand, double band_m);

// Contact points of pads that stopped at `contact`; the pad at low x comes first.
std::array<PadPatch, 2> TouchedPatches(const SurfacePoints& surface, const PointColumns& turned,
                                       const Pose& X_OG, const HandSpec& hand,
                                       const PadContact& contact, double band_m);

// Returns true if no point is within `margin_m` of the boxes (in G) or of the volume that they pass
// on the straight approach along z of G.
bool HandClearsObject(const PointColumns& turned, const Pose& X_OG,
                      std::span<const AxisAlignedBox> boxes_G, double margin_m);

}  // namespace pickbed::grasp
