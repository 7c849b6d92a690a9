#pragma once

// How sure a grasp is: the share of sampled errors of pose, friction and mass under which the part
// is still lifted, as in Weisz and Allen 2012 and Mahler et al. 2017, but with the weight in the
// balance: a sample counts when the hand gets hold of the part without hitting it and its contacts
// balance weight and lift at once (quasi-static, grasp/wrench_space.h).

#include <functional>
#include <optional>

#include "grasp/wrench_space.h"
#include "scenes/object_model.h"
#include "scenes/random.h"
#include "scenes/settings.h"

namespace pickbed {

struct RobustOptions {
  int samples = 32;             // the same errors for every candidate, so that they compare
  double position_m = 0.002;    // sigma of each axis, hand against part
  double rotation_rad = 0.035;  // sigma of the turn about a random axis
  double friction_share = 0.2;  // sigma, of the pair's friction
  double mass_share = 0.1;      // sigma, of the part's mass
  double com_share = 0.02;      // sigma of each axis of the centre of mass, of the diameter
  double tilt_rad = 0.5;        // of the hand from straight down when it lifts, at most
  double lift_mps2 = 2;         // acceleration upwards
  double touch_band_m =
      0.002;                   // surface this near to the first touch: the part turns into the pads
  double least_factor = 0.05;  // of friction and mass, however far out a sample lies
  int cone_edges = 8;          // of a friction cone made a pyramid
  void Visit(SettingsVisitor& v);
};

inline constexpr double kGravity_mps2 = 9.81;

// The unit of a grasp's wrenches: weight, and half the diameter for torques.
double WrenchForce_n(const ObjectModel& model);
double WrenchRadius_m(const ObjectModel& model);

// What a hand at this pose can put on the part, in those units, with the pair's friction times a
// factor; nothing when it does not get hold of it.
using HoldFunction =
    std::function<std::optional<WrenchSet>(const Pose& X_OG, double friction_factor)>;

// 0..1. The samples follow from `rng`, which is taken by value: the same for every candidate.
double RobustShare(const ObjectModel& model, const Pose& X_OG, const HoldFunction& hold, Rng rng,
                   const RobustOptions& options);

}  // namespace pickbed
