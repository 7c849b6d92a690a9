#pragma once

// What is known of how a scene came to rest, and whether it may be used.

#include <string>
#include <vector>

namespace pickbed {

struct EnergySample {
  double time_s = 0;
  double kinetic_j = 0;
  double potential_j = 0;  // 0 with all centres of mass on the bin's floor
};

struct SceneCertificate {
  bool at_rest = false;      // else timed out
  double simulated_s = 0;    // pouring included
  bool blew_up = false;      // a body's state was not finite or faster than 50 m/s
  int parts_outside = 0;     // centre of mass outside the bin at the end: they are not in the scene
  double max_speed_mps = 0;  // at the end, of the centres of mass
  double max_spin_radps = 0;  // at the end
  // At the end, hull against hull by an exact separating-axis test, margins not counted.
  double deepest_penetration_m = 0;
  // Largest movement of any part's surface in the last second, in which all parts were awake and
  // began without remembered contacts: a bound, also as a share of that part's diameter.
  double wake_movement_m = 0;
  double wake_movement_diameters = 0;
  std::vector<EnergySample> energy;  // about every 0.05 s
};

// One line for each reason to refuse the scene; empty = certified.
struct CertificateLimits {
  double penetration_m = 0.0005;
};
std::vector<std::string> Faults(const SceneCertificate& certificate,
                                const CertificateLimits& limits = {});

}  // namespace pickbed
