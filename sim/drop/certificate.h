#pragma once

// Scene certificate: measurements of how a scene came to rest, and the rules for its acceptance.

#include <string>
#include <vector>

#include "sim/layer.h"

namespace pickbed::sim {

struct EnergySample {
  double time_s = 0;
  double kinetic_j = 0;
  double potential_j = 0;  // 0 if all centers of mass are on the bin floor
};

// Measurements of how a scene came to rest. Faults() decides whether it may be used.
struct SceneCertificate {
  bool at_rest = false;    // false = timed out
  double simulated_s = 0;  // includes the pouring
  bool blew_up = false;    // a body's state was not finite, or a body was faster than 50 m/s
  // Instances whose center of mass ended outside the bin. They are not in the scene.
  int instances_outside = 0;
  double max_speed_mps = 0;   // largest final speed of a center of mass
  double max_spin_radps = 0;  // largest final angular speed
  // Deepest final overlap of two bodies' convex pieces, by an exact separating-axis test. Collision
  // margins are not counted.
  double deepest_penetration_m = 0;
  // Upper bound of the movement of any instance's surface in the last second, in metres and as a
  // share of its diameter. All instances are awake in that second and start without remembered
  // contacts.
  double wake_movement_m = 0;
  double wake_movement_diameters = 0;
  std::vector<EnergySample> energy;  // about every 0.05 s
};

// Limits that a certificate must meet.
struct CertificateLimits {
  double penetration_m = 0.0005;
};
// Returns one line per reason to refuse the scene. Empty = certified.
std::vector<std::string> Faults(const SceneCertificate& certificate,
                                const CertificateLimits& limits = {});

}  // namespace pickbed::sim
