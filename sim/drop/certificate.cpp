#include "sim/drop/certificate.h"

#include <fmt/format.h>

namespace pickbed::sim {

std::vector<std::string> Faults(const SceneCertificate& certificate,
                                const CertificateLimits& limits) {
  std::vector<std::string> faults;
  if (certificate.blew_up) {
    faults.emplace_back("physics failed: a body's state is not finite or too fast");
    return faults;  // The other fields are not reliable then.
  }
  if (!certificate.at_rest) {
    faults.push_back(fmt::format("not at rest after {:.1f} s", certificate.simulated_s));
  }
  if (certificate.instances_outside > 0) {
    faults.push_back(fmt::format("{} instance{} fell outside the bin",
                                 certificate.instances_outside,
                                 certificate.instances_outside == 1 ? "" : "s"));
  }
  if (certificate.deepest_penetration_m > limits.penetration_m) {
    faults.push_back(
        fmt::format("two bodies overlap by {:.2f} mm", 1e3 * certificate.deepest_penetration_m));
  }
  return faults;
}

}  // namespace pickbed::sim
