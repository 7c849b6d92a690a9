#pragma once

// Simulated data sets in BOP's layout. A scene is an item of work: it is written under a temporary
// name and gets its own when it is whole, so that a run that is killed at any moment can be
// resumed. The bytes are those of (scenario, views, split), whatever the number of jobs and
// interruptions.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/workers.h"
#include "scenes/camera.h"
#include "scenes/random.h"
#include "scenes/scenario_spec.h"

namespace pickbed::bop {

struct MakeOptions {
  std::filesystem::path out;
  std::string split = "test";
  int scenes = 10;
  int views = 5;  // of each scene
  int jobs = 1;
  bool resume = false;
};

// How views are drawn: the first is the scenario's camera, the others stand around it.
struct ViewSpread {
  double distance_min = 0.88;  // over that of the scenario's camera to what it looks at
  double distance_max = 1.15;
  double tilt_rad = 0.25;       // more or less than the scenario's camera, either way
  double roll_rad = 0.25;       // either way
  double target_m = 0.02;       // of the point that is looked at, x and y, either way
  double above_walls_m = 0.05;  // least height of the camera over the walls' upper edge
};

// The camera turned about the vertical through the point it looks at by any angle, and moved as
// `spread` says.
Camera RandomView(const ScenarioSpec& spec, const ViewSpread& spread, Rng& rng);

struct MakeReport {
  int done = 0;         // scenes on disk
  int done_before = 0;  // of these, found when resuming
  bool stopped = false;
  std::vector<LostItem> lost;  // by scene id
};

// Writes models/, camera.json, the scenes (ids from 1; scene id - 1 is the scenario's trial),
// target files and dataset_card.json and .md. Cards and targets are written when all scenes are
// there. Throws InputError when `out` holds scenes and `resume` is not set, or those of other
// settings. Forks: see eval/workers.h.
MakeReport MakeDataset(const ScenarioSpec& spec, const ObjectSet& objects,
                       const MakeOptions& options,
                       const std::function<void(const MakeReport&)>& on_scene = {},
                       const std::function<bool()>& stop = {});

}  // namespace pickbed::bop
