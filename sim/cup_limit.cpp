#include "sim/cup_limit.h"

#include <algorithm>
#include <cmath>

namespace pickbed {

double RingRadius_m(const CupSpec& spec) {
  return std::min(spec.radius_m, spec.moment_limit_nm / spec.vacuum_n);
}

double ShareOfLimit(const CupSpec& spec, double pair_friction, const LipLoad& load) {
  const double pull_n = std::max(load.force_n.z(), -spec.vacuum_n);
  const double radius_m = RingRadius_m(spec);
  const double bend_nm = load.torque_nm.head<2>().norm();
  // The ring's force is vacuum_n - pull_n, which bears bending up to that times the radius.
  const double peel = (pull_n + bend_nm / radius_m) / spec.vacuum_n;
  const double grip_n = pair_friction * (spec.vacuum_n - pull_n);
  if (peel >= 1 || grip_n <= 0) return std::max(1.0, peel);
  const double shear = load.force_n.head<2>().norm() / grip_n;
  const double twist = load.torque_nm.z() / (grip_n * radius_m);
  return std::max(peel, std::hypot(shear, twist));
}

}  // namespace pickbed
