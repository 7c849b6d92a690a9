#pragma once

// Seal test of a suction cup on an object's mesh, by rays along the approach from the rim and from
// rings inside it.

#include <array>

#include "scenes/geometry/mesh_query.h"
#include "scenes/geometry/pose.h"
#include "sim/hands/suction_hand.h"

namespace pickbed::sim {

// Reason why a cup does not seal.
enum class SealFault {
  kNone,
  kMissed,  // a rim ray meets no surface within the bellows' travel
  kTooFar,  // the object is in the way of the stem, so the bellows would be fully compressed
  kUneven,  // the lip cannot follow the surface: an edge, a step or a strong curvature
  kLeaks,   // a through hole inside the rim
};

// Number and placement of the test rays.
struct SealOptions {
  // On the rim, at least 8. They are 3 mm apart on a 15 mm lip, so they find all gaps too wide for
  // the lip.
  int rim_rays = 32;
  int inner_rays = 12;                           // on each inner ring, to find holes
  std::array<double, 2> inner_rings{0.4, 0.75};  // of the lip's radius; the center is tested too
  double reach_beyond_m = 0.0002;  // the lip also seals on surfaces this far beyond it; 0..0.001
};

// Result of TestSeal().
struct CupSeal {
  SealFault fault = SealFault::kMissed;
  double compression_m = 0;  // of the bellows: mean over the rim, 0 without contact
  Eigen::Vector2d press_center_m = Eigen::Vector2d::Zero();  // x, y in G of the bellows' force
  double touching = 0;  // share of rim rays that meet the surface within the travel
  double uneven_m = 0;  // largest distance of the rim's hits from their plane, along z
  double tilt_rad = 0;  // tilt of that plane against the cup
  bool sealed() const { return fault == SealFault::kNone; }
};

// Tests the cup at pose X_OG on the object's true surface. A tilted plane seals if the bellows'
// travel compensates the tilt. The remaining distances from the plane must be at most
// lip_conform_m.
CupSeal TestSeal(const MeshQuery& mesh_O, const Pose& X_OG, const CupSpec& spec,
                 const SealOptions& options = {});

}  // namespace pickbed::sim
