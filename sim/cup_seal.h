#pragma once

// Whether a suction cup seals on a part: rays along the approach from the rim, and from rings
// inside it, against the part's mesh.

#include <array>

#include "scenes/mesh_query.h"
#include "scenes/pose.h"
#include "sim/cup_joint.h"

namespace pickbed {

enum class SealFault {
  kNone,
  kMissed,  // a ray of the rim meets no surface within the bellows' travel
  kTooFar,  // the part is in the way of the stem: the bellows would be pressed together for good
  kUneven,  // the lip cannot follow the surface: an edge, a step, a strong curve
  kLeaks,   // a hole goes through the part inside the rim
};
const char* SealFaultName(SealFault fault);

struct SealOptions {
  int rim_rays = 32;    // 3 mm apart on a lip of 15 mm: finer than what a lip cannot close; from 8
  int inner_rays = 12;  // on each ring inside, where holes are looked for
  std::array<double, 2> inner_rings{0.4, 0.75};  // shares of the lip's radius; and the middle
  double reach_beyond_m = 0.0002;  // a lip clings to what it just misses, beyond its end; 0..0.001
};

struct CupSeal {
  SealFault fault = SealFault::kMissed;
  double compression_m = 0;  // of the bellows: mean over the rim, 0 where it meets nothing
  Eigen::Vector2d press_center_m = Eigen::Vector2d::Zero();  // x, y of G of the bellows' force
  double touching = 0;  // share of the rim's rays that meet the surface within the travel
  double uneven_m = 0;  // largest distance of the rim's hits from their plane, along z
  double tilt_rad = 0;  // of that plane
  bool sealed() const { return fault == SealFault::kNone; }
};

// The cup at X_OG, by the part's true surface. A plane that is tilted is sealed as long as the
// travel takes it up; what is left beside the plane must be within lip_conform_m.
CupSeal TestSeal(const MeshQuery& mesh_O, const Pose& X_OG, const CupSpec& spec,
                 const SealOptions& options = {});

}  // namespace pickbed
