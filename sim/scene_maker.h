#pragma once

// Certified scenes: drops until one has no fault, and keeps the account of those it refused.

#include <string>
#include <vector>

#include "sim/drop.h"

namespace pickbed {

struct SceneRequest {
  Bin bin;
  const ObjectSet& objects;  // with convex pieces
  std::vector<int> counts;   // of each object
  uint64_t seed = 0;         // of the scenario
  uint64_t trial = 0;
  // Name of the streams of random numbers; another one gives another scene of the same trial.
  std::string stage = "drop";
};

struct RefusedScene {
  int attempt = 0;
  std::vector<std::string> faults;
};

struct CertifiedScene {
  Scene scene;
  SceneCertificate certificate;
  std::vector<RefusedScene> refused;  // before it, in order
};

// Attempt 0, 1, ... each with a stream of random numbers of its own, derived from seed, trial and
// attempt, until a scene passes. Throws InputError when `max_attempts` in a row do not, with the
// last one's faults, and where DropParts does.
CertifiedScene MakeScene(const SceneRequest& request, const DropOptions& options = {},
                         int max_attempts = 10);

}  // namespace pickbed
