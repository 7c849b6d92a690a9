#pragma once

// What the pads of a parallel hand would touch on a part alone, without physics: how wide they
// stop, on how much surface, and whether the rest of the hand is clear of the part.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "grasp/gripper.h"
#include "scenes/object_model.h"
#include "scenes/random.h"

namespace pickbed {

// Points by row; single precision in columns, since candidates by the ten thousand are tested.
using PointColumns = Eigen::Array<float, Eigen::Dynamic, 3>;

// The surface of a part as points spread evenly by area.
struct SurfacePoints {
  PointColumns points_O;
  PointColumns normals_O;
  double area_m2 = 0;  // that one point stands for
};

// About one point every `spacing_m` squared, within the limits given.
SurfacePoints SpreadPoints(const TriangleMesh& mesh, double spacing_m, int min_count, int max_count,
                           Rng& rng);

// The points in the axes of G, origin still that of O: shared by all hands of one orientation.
PointColumns Turned(const PointColumns& points_O, const Eigen::Matrix3d& R_OG);

struct PadContact {
  bool touches = false;      // both pads meet surface that faces them
  double low_x_m = 0;        // where the pads stop, along x of G
  double high_x_m = 0;       //
  double area_m2 = 0;        // of the smaller of the two contacts
  double max_angle_rad = 0;  // of a contact's mean normal to the closing axis, the larger
  // Rectangle on the pads in (y, z) of G that both contacts share; empty when min > max.
  Eigen::Vector2d shared_min = Eigen::Vector2d::Zero();
  Eigen::Vector2d shared_max = Eigen::Vector2d::Zero();

  double width_m() const { return high_x_m - low_x_m; }
  bool shared() const { return (shared_max.array() >= shared_min.array()).all(); }
  Eigen::Vector2d shared_center() const { return 0.5 * (shared_min + shared_max); }
};

// Where one pad touches: places in G, and the mean of the surface's normals there.
struct PadPatch {
  std::vector<Eigen::Vector3d> points_G;
  Eigen::Vector3d normal_G = Eigen::Vector3d::Zero();  // unit, out of the part
};

// Closes the pads of `hand` at X_OG on the part; `turned` are its points turned by R_OG. Surface
// within `band_m` of the first touch counts as contact. Places are in G.
PadContact ClosePads(const SurfacePoints& surface, const PointColumns& turned, const Pose& X_OG,
                     const HandSpec& hand, double band_m);

// The patches of pads that stopped as `contact` says: low x first.
std::array<PadPatch, 2> TouchedPatches(const SurfacePoints& surface, const PointColumns& turned,
                                       const Pose& X_OG, const HandSpec& hand,
                                       const PadContact& contact, double band_m);

// True when no point is within `margin_m` of the hand's boxes (in G), or of where they pass on the
// straight approach along z of G.
bool HandClearsPart(const PointColumns& turned, const Pose& X_OG,
                    std::span<const AxisAlignedBox> boxes_G, double margin_m);

}  // namespace pickbed
