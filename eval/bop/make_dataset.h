#pragma once

// Simulated data sets in BOP's layout. Each scene is written under a temporary name and renamed
// when it is complete. A run that is killed at any moment can therefore be resumed. The bytes
// depend only on (scenario, views, split), not on the number of jobs or interruptions.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/runtime/process_pool.h"
#include "scenes/base/random.h"
#include "scenes/camera/camera.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

struct MakeDatasetOptions {
  std::filesystem::path out;
  std::string split = "test";
  int scenes = 10;
  int views = 5;  // images per scene; 0 in the card of a run = one per attempt
  int jobs = 1;
  bool resume = false;
};

// Sampling ranges of the views of a scene. The first view is the scenario's camera. The others are
// sampled around its target point.
struct ViewSpread {
  double distance_min = 0.88;  // distance to the target, relative to the scenario's camera
  double distance_max = 1.15;
  double tilt_rad = 0.25;       // +-, about camera x, relative to the scenario's camera
  double roll_rad = 0.25;       // +-, about camera z
  double target_m = 0.02;       // +-, shift of the target point in world x and y
  double above_walls_m = 0.05;  // minimum height of the camera above the upper edge of the walls
};

// Samples a view: rotates the scenario's camera by any angle about the vertical through its target,
// then varies distance, tilt, roll and target within `spread`. Returns the scenario's camera if 100
// samples are all too low.
Camera RandomCamera(const ScenarioSpec& spec, const ViewSpread& spread, Rng& rng);

struct MakeDatasetReport {
  int done = 0;         // requested scenes that are on disk
  int done_before = 0;  // requested scenes that were on disk before the run
  bool stopped = false;
  std::vector<LostItem> lost;  // by scene id
};

// Returns the lost scenes that are not among the written ones. A worker that was killed after it
// wrote a scene and before it said so has lost nothing. `written` is ascending.
std::vector<LostItem> NotWritten(std::vector<LostItem> lost, const std::vector<int>& written);

// Writes models/ and models_eval/, camera.json, stored_scenario.yaml, the scenes, target files, and
// dataset_card.json and .md. Each scene folder also has the settled scene (stored_scenes.h). Scene
// ids start at 1; scene id - 1 is the scenario's trial. Cards and targets are written when all
// scenes are complete. `on_scene` is called after each scene. `stop` returns true to end the run.
// Throws InputError if `out` holds scenes and `resume` is not set, or holds scenes of other
// settings. Forks: see eval/runtime/process_pool.h.
MakeDatasetReport MakeDataset(const ScenarioSpec& spec, const ObjectSet& objects,
                              const MakeDatasetOptions& options,
                              const std::function<void(const MakeDatasetReport&)>& on_scene = {},
                              const std::function<bool()>& stop = {});

}  // namespace pickbed::eval
