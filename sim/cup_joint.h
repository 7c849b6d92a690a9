#pragma once

// A suction cup: a bellows with a thin lip at the end of a stem that is driven along a path. It
// holds a part by one joint that breaks by pull, moment or shear, see sim/cup_limit.h.

#include <Eigen/Core>
#include <vector>

#include "scenes/bin.h"

namespace pickbed {

// Frame G: z approach (along the stem, out of the lip), origin in the middle of the uncompressed
// lip, x any direction across. The stem starts a travel behind the lip, the palm behind the stem.
struct CupSpec {
  double radius_m = 0.015;          // of the lip
  double bellows_travel_m = 0.008;  // from the uncompressed lip to the stem's end
  double press_m = 0.003;           // compression that a grasp aims at; takes up errors of depth
  double bellows_npm = 300;         // stiffness of the bellows while it is not sealed, N/m
  double lip_conform_m = 0.0015;    // unevenness along the rim that the lip still closes
  double vacuum_n = 45;             // pull at which it comes off; 0.64 bar on the default radius
  double moment_limit_nm = 0.6;     // bending moment about the lip's middle, likewise
  double friction = 0.8;            // own value of the lip in the pair rule of scenes/friction.h
  double break_after_s = 0.02;      // limits are judged on the mean load over this time
  double stem_radius_m = 0.012;     // half the side of the stem's box
  double stem_length_m = 0.10;      //
  Eigen::Vector3d palm_size_m{0.06, 0.06, 0.04};  // box behind the stem
};

// The hand's boxes (stem, palm) in G, for collision checks. Bellows and lip give way.
std::vector<AxisAlignedBox> CupBoxes(const CupSpec& spec);

}  // namespace pickbed
