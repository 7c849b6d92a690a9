#pragma once

// A minimal BOP data set for tests: cubes, small images, an ideal sensor, no catalog files.

#include <filesystem>
#include <functional>

#include "eval/bop/make_dataset.h"
#include "tests/eval/cube_scenario.h"

namespace pickbed::tests {

inline constexpr int kSmallInstances = 3;

inline ScenarioSpec SmallScenario(int instances = kSmallInstances) {
  ScenarioSpec spec = CubeScenario(instances);
  spec.sensor = "ideal";
  spec.camera.width = 96;
  spec.camera.height = 72;
  spec.camera.focal_px = 160;
  spec.camera.eye_m = {0, -0.1, 0.6};
  return spec;
}

inline MakeDatasetReport MakeSmall(const std::filesystem::path& out, int scenes, int views,
                                   int jobs = 1, bool resume = false,
                                   const std::function<bool()>& stop = {},
                                   int instances = kSmallInstances) {
  MakeDatasetOptions options;
  options.out = out;
  options.scenes = scenes;
  options.views = views;
  options.jobs = jobs;
  options.resume = resume;
  return MakeDataset(SmallScenario(instances), EasyCube(), options, {}, stop);
}

}  // namespace pickbed::tests
