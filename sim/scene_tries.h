#pragma once

// Drops until a scene has no fault, where it is no error that none of them has.

#include <optional>
#include <vector>

#include "sim/scene_maker.h"

namespace pickbed {

struct SceneTries {
  std::optional<CertifiedScene> made;  // with the refused ones, too
  std::vector<RefusedScene> refused;   // in order
};

// Attempt 0, 1, ... each with a stream of random numbers of its own, derived from seed, trial and
// attempt, until a scene passes or `max_attempts` have been refused. Throws where DropParts does.
SceneTries TryScene(const SceneRequest& request, const DropOptions& options, int max_attempts = 10);

}  // namespace pickbed
