#pragma once

// Robustness of a grasp: the share of sampled errors of pose, friction and mass under which the
// object is still lifted, as in Weisz and Allen 2012 and Mahler et al. 2017. In addition, the
// contacts must balance weight and lift at once (quasi-static, grasp/candidates/wrench_space.h). A
// sample also fails if the hand hits the object or does not get hold of it.

#include <functional>
#include <optional>

#include "grasp/candidates/wrench_space.h"
#include "scenes/base/random.h"
#include "scenes/base/settings.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

// Sampled errors and load of the robustness test.
struct RobustOptions {
  int samples = 32;           // every candidate gets the same errors, so that shares are comparable
  double position_m = 0.002;  // sigma per axis of the hand position relative to the object
  double rotation_rad = 0.035;  // sigma of the rotation about a random axis
  double friction_share = 0.2;  // sigma, as a share of the pair friction
  double mass_share = 0.1;      // sigma, as a share of the mass of the object
  double com_share = 0.02;      // sigma per axis of the center of mass, as a share of the diameter
  double tilt_rad = 0.5;        // maximum angle of the hand from straight down during the lift
  double lift_mps2 = 2;         // upward acceleration
  // Surface within this distance of the first touch is in contact. The band is wider than in
  // AntipodalOptions, because the object rotates into the pads.
  double touch_band_m = 0.002;
  double min_factor = 0.05;  // lower bound of the sampled factors of friction and mass
  int cone_edges = 8;        // edges of the pyramid that replaces a friction cone
  void Visit(SettingsVisitor& v);
};

// Returns the unit of the forces of a grasp: the weight of the object, in N.
double WrenchForce_n(const ObjectModel& model);
// Returns the lever of torques: half the diameter of the object, in m.
double WrenchRadius_m(const ObjectModel& model);

// Wrenches that a hand at X_OG can exert on the object, in these units; the pair friction is
// multiplied by a factor. Returns nullopt if the hand does not get hold of the object.
using HoldFunction =
    std::function<std::optional<WrenchSet>(const Pose& X_OG, double friction_factor)>;

// Share 0..1 of samples in which the grasp balances weight and lift. `rng` is taken by value, so
// that every candidate sees the same samples.
double RobustShare(const ObjectModel& model, const Pose& X_OG, const HoldFunction& hold, Rng rng,
                   const RobustOptions& options);

}  // namespace pickbed::grasp
