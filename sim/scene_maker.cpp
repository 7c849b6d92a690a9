#include "sim/scene_maker.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/check.h"
#include "sim/scene_tries.h"

namespace pickbed {

SceneTries TryScene(const SceneRequest& request, const DropOptions& options, int max_attempts) {
  SceneTries tries;
  for (int attempt = 0; attempt < max_attempts; ++attempt) {
    const std::string stage =
        attempt == 0 ? request.stage : fmt::format("{}/{}", request.stage, attempt);
    Rng rng = Rng::Derive(request.seed, request.trial, stage);
    DropResult drop = DropParts(request.bin, request.objects, request.counts, rng, options);
    std::vector<std::string> faults = Faults(drop.certificate);
    if (faults.empty()) {
      tries.made = {std::move(drop.scene), std::move(drop.certificate), tries.refused};
      return tries;
    }
    tries.refused.push_back({attempt, std::move(faults)});
  }
  return tries;
}

CertifiedScene MakeScene(const SceneRequest& request, const DropOptions& options,
                         int max_attempts) {
  SceneTries tries = TryScene(request, options, max_attempts);
  if (tries.made) return *std::move(tries.made);
  throw InputError(fmt::format(
      "trial {}: {} scenes in a row were refused, the last because {}; drop fewer parts or take a "
      "larger bin",
      request.trial, max_attempts, fmt::join(tries.refused.back().faults, ", ")));
}

}  // namespace pickbed
