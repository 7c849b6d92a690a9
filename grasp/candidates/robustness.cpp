#include "grasp/candidates/robustness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/objects/contact.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

Vector3d NormalVector(double sigma, Rng& rng) {
  const double x = rng.Normal(), y = rng.Normal(), z = rng.Normal();
  return sigma * Vector3d(x, y, z);
}

// Random direction of gravity in G: within `tilt_rad` of the approach direction +z.
Vector3d DownInHand(double tilt_rad, Rng& rng) {
  const double cosine = rng.Uniform(std::cos(tilt_rad), 1.0);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double turn = rng.Uniform(0, 2 * std::numbers::pi);
  return {sine * std::cos(turn), sine * std::sin(turn), cosine};
}

}  // namespace

void RobustOptions::Visit(SettingsVisitor& v) {
  v.Integer("samples", samples, {1, 100000}, "number of sampled errors per candidate");
  v.Real("position_m", position_m, {0, 0.1},
         "standard deviation of the hand position relative to the object per axis, m");
  v.Real("rotation_rad", rotation_rad, {0, 1}, "standard deviation of the rotation, rad");
  v.Real("friction_share", friction_share, {0, 1}, "relative standard deviation of the friction");
  v.Real("mass_share", mass_share, {0, 1}, "relative standard deviation of the mass");
  v.Real("com_share", com_share, {0, 0.5},
         "standard deviation of the center of mass per axis, object diameters");
  v.Real("tilt_rad", tilt_rad, {0, 3.2},
         "maximum angle of the hand from straight down during the lift, rad");
  v.Real("lift_mps2", lift_mps2, {0, 100}, "upward acceleration of the lift, m/s2");
  v.Real("touch_band_m", touch_band_m, {1e-5, 0.02},
         "depth of the surface band that counts as contact, m");
  v.RenamedKey("least_factor", "min_factor");
  v.Real("min_factor", min_factor, {0.001, 1},
         "lower limit of the sampled factors of friction and mass");
  v.Integer("cone_edges", cone_edges, {3, 64},
            "edges of the pyramid that approximates a friction cone");
}

double WrenchForce_n(const ObjectModel& model) { return model.mass.mass_kg * kGravity_mps2; }

double WrenchRadius_m(const ObjectModel& model) { return 0.5 * model.diameter_m; }

double RobustShare(const ObjectModel& model, const Pose& X_OG, const HoldFunction& hold, Rng rng,
                   const RobustOptions& options) {
  int held = 0;
  for (int i = 0; i < options.samples; ++i) {
    Pose X_OS = X_OG;
    X_OS.translate(NormalVector(options.position_m, rng));
    const Vector3d axis = rng.UnitVector();
    X_OS.rotate(Eigen::AngleAxisd(options.rotation_rad * rng.Normal(), axis));
    const double friction = std::max(options.min_factor, 1 + options.friction_share * rng.Normal());
    const double mass = std::max(options.min_factor, 1 + options.mass_share * rng.Normal());
    const Vector3d com_shift_O = NormalVector(options.com_share * model.diameter_m, rng);
    const Vector3d down_O = X_OS.linear() * DownInHand(options.tilt_rad, rng);
    const std::optional<WrenchSet> set = hold(X_OS, friction);
    if (!set) continue;
    const Vector3d force = mass * (1 + options.lift_mps2 / kGravity_mps2) * down_O;
    Wrench load;
    load << force, com_shift_O.cross(force) / WrenchRadius_m(model);
    held += Balances(*set, load);
  }
  return static_cast<double>(held) / options.samples;
}

}  // namespace pickbed::grasp
