#pragma once

// A sweep without physics: what a trial gives follows from its seed and scene alone.

#include <fmt/format.h>

#include <functional>
#include <string>

#include "eval/sweep.h"
#include "tests/eval/full_trial.h"

namespace pickbed {

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
    SweepPoint point;
    point.point = p;
    point.name = fmt::format("seed={}", p + 5);
    point.spec = StubScenario(p + 5);
    point.spec.trials = trials;
    point.identity = fmt::format("seed: {}\n", p + 5);
    point.first_trial = p * trials;
    point.trials = trials;
    sweep.points.push_back(std::move(point));
  }
  return sweep;
}

// `before` runs before each trial, in the worker.
using BeforeTrial = std::function<void(const SweepPoint& point, int scene)>;
inline MakeDoTrial StubTrials(const BeforeTrial& before = [](const SweepPoint&, int) {}) {
  return [before](const SweepPoint& point, const WorkerPlan::Say&) -> DoTrial {
    return [&point, before](int scene, const PictureOrder&) {
      before(point, scene);
      TrialResult result = FullTrial(static_cast<int>(100 * point.spec.seed) + scene);
      result.seconds = {{"drop", 0.5}};
      return result;
    };
  };
}

}  // namespace pickbed
