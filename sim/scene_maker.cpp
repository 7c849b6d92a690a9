#include "sim/scene_maker.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/check.h"

namespace pickbed {

CertifiedScene MakeScene(const SceneRequest& request, const DropOptions& options,
                         int max_attempts) {
  CertifiedScene made;
  for (int attempt = 0; attempt < max_attempts; ++attempt) {
    const std::string stage =
        attempt == 0 ? request.stage : fmt::format("{}/{}", request.stage, attempt);
    Rng rng = Rng::Derive(request.seed, request.trial, stage);
    DropResult drop = DropParts(request.bin, request.objects, request.counts, rng, options);
    std::vector<std::string> faults = Faults(drop.certificate);
    if (faults.empty()) {
      made.scene = std::move(drop.scene);
      made.certificate = std::move(drop.certificate);
      return made;
    }
    made.refused.push_back({attempt, std::move(faults)});
  }
  throw InputError(fmt::format(
      "trial {}: {} scenes in a row were refused, the last because {}; drop fewer parts or take a "
      "larger bin",
      request.trial, max_attempts, fmt::join(made.refused.back().faults, ", ")));
}

}  // namespace pickbed
