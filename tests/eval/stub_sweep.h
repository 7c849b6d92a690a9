#pragma once

// A sweep without physics. The result of a trial depends only on its seed and bin index.

#include <fmt/format.h>

#include <functional>
#include <string>

#include "eval/sweep/sweep.h"
#include "tests/eval/full_trial.h"

namespace pickbed::tests {

inline ScenarioSpec StubScenario(uint64_t seed) {
  ScenarioSpec spec;
  spec.seed = seed;
  spec.objects.resize(2);
  spec.objects[0].name = "rod";
  spec.objects[1].name = "flange";
  return spec;
}

inline Sweep StubSweep(int points, int trials) {
  Sweep sweep;
  sweep.yaml = "scenario: stub\n";
  for (int p = 0; p < points; ++p) {
    Configuration point;
    point.number = p;
    point.name = fmt::format("seed={}", p + 5);
    point.spec = StubScenario(p + 5);
    point.spec.trials = trials;
    point.identity = fmt::format("seed: {}\n", p + 5);
    point.first_trial = p * trials;
    point.trials = trials;
    sweep.configurations.push_back(std::move(point));
  }
  return sweep;
}

// `before` runs in the worker before each trial.
using BeforeTrial = std::function<void(const Configuration& point, int scene)>;
inline MakeDoTrial StubTrials(const BeforeTrial& before = [](const Configuration&, int) {}) {
  return [before](const Configuration& point, const WorkerPlan::Say&) -> DoTrial {
    return [&point, before](int scene, const PictureOrder&) {
      before(point, scene);
      TrialResult result = FullTrial(static_cast<int>(100 * point.spec.seed) + scene);
      result.instances_cleared = 0;  // none of the attempts succeeds
      result.seconds = {{"drop", 0.5}};
      return result;
    };
  };
}

}  // namespace pickbed::tests
