#pragma once

// Suction cup: bellows with a thin lip at the end of a stem that follows a path. A joint holds the
// object and breaks by pull, moment or shear.

#include <Eigen/Core>
#include <vector>

#include "scenes/bin/bin.h"
#include "sim/hands/hand.h"
#include "sim/physics/physics_world.h"

namespace pickbed::sim {

// Dimensions and limits of the cup. Frame G: z approach (along the stem, out of the lip), x any
// perpendicular direction. The origin is the center of the uncompressed lip. The stem begins one
// bellows travel behind the lip, with the palm behind it.
//
//     +-------+
//     | palm  |
//     +--+-+--+
//        | |    stem
//        +-+
//        / \    bellows
//       +-G-+ ---> x
//         |     lip
//         v z (approach)
struct CupSpec {
  double radius_m = 0.015;          // radius of the lip
  double bellows_travel_m = 0.008;  // from the uncompressed lip to the stem's end
  double press_m = 0.003;           // target compression of a grasp; absorbs depth errors
  double bellows_npm = 300;         // stiffness of the unsealed bellows, N/m
  double lip_conform_m = 0.0015;    // unevenness along the rim that the lip can still seal
  double vacuum_n = 45;          // pull at which the cup detaches; 0.64 bar at the default radius
  double moment_limit_nm = 0.6;  // bending moment about the lip's center at which it detaches
  double friction = 0.8;         // the lip's value in the pair rule of scenes/objects/contact.h
  double break_after_s = 0.02;   // limits apply to the mean load over this time
  double stem_radius_m = 0.012;  // half the side of the stem's box
  double stem_length_m = 0.10;
  Eigen::Vector3d palm_size_m{0.06, 0.06, 0.04};  // box behind the stem
};

// Adds the hand to the world, which owns it. The hand reads the objects' meshes, so the models
// given to AddInstance() must outlive the world. Throws std::logic_error if the world has a hand
// already.
Hand& AddSuctionHand(PhysicsWorld& world, const CupSpec& spec, const Pose& X_WG);

// Returns the hand's boxes (stem, palm) in G, for collision checks. Bellows and lip are compliant
// and are not included.
std::vector<AxisAlignedBox> CupBoxes(const CupSpec& spec);

// Strength of a sealed lip, used by the breaking joint and by the planner.
//
// The lip is a ring of contact (Mahler et al. 2018, "Dex-Net 3.0", section IV). The air presses it
// on with vacuum_n. A pull reduces this force, and a push adds to it, by at most as much again. The
// ring carries bending until the whole force acts on one of its points. It carries shear and
// torsion by friction, limited by an ellipsoid. The ring radius is at most the lip's, and such that
// the cup tips off at moment_limit_nm without a pull.

// Load of the object on the cup in G, about the lip's center.
struct LipLoad {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_nm = Eigen::Vector3d::Zero();
};

// Returns the radius of the contact ring.
double RingRadius_m(const CupSpec& spec);

// Returns the load as a share of the strength; from 1 on, the lip detaches. `pair_friction` is
// defined in scenes/objects/contact.h.
double ShareOfLimit(const CupSpec& spec, double pair_friction, const LipLoad& load);

}  // namespace pickbed::sim
