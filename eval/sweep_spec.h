#pragma once

// SWEEP.yaml: which settings a sweep varies.
//
//   scenario: bin_bracket          # a preset, or a file (relative to this one)
//   trials: 40                     # bins a point; left out: the scenario's
//   set: {gripper: cup_30mm}       # settings of all points
//   grid:                          # cartesian product, the first key slowest
//     sensor: [ideal, time_of_flight]
//     seed: 1..3                   # whole numbers from 1 to 3
//     method:                      # several keys changed together, under names of your own
//       ppf: {estimator.name: ppf, estimator.mode: verified}      # point method=ppf
//       learned: {estimator.name: descriptor}
//     pair: [{sensor: ideal, refiner: none}, {sensor: time_of_flight}]    # named by their settings
//   occlusion: {...}               # settings of that group, for all points
//   slurm: {...}                   # see eval/slurm.h
//
// Any key of `pickbed list settings` may stand in set and grid.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/slurm.h"
#include "eval/sweep.h"
#include "scenes/settings_tree.h"

namespace pickbed {

struct GridValue {
  std::string name;  // "estimator.name=ppf,estimator.mode=verified"
  std::vector<PlacedSetting> settings;
};
struct GridAxis {
  std::string key;
  std::vector<GridValue> values;
};

struct SweepSpec {
  std::string name;      // of the file, without folder and ending
  std::string scenario;  // a preset, or an absolute path
  std::optional<int> trials;
  std::vector<PlacedSetting> set;
  std::vector<GridAxis> grid;
  SlurmOptions slurm;
  std::string grid_text;  // as it was written, in flow style
};

// Throws InputError with file and line for an unknown key, an empty or broken grid and one that
// sets a key by two axes. What the
// grid's keys and values mean is checked by MakeSweep.
SweepSpec LoadSweepSpec(const std::filesystem::path& file);

// Adds "key=value" of the command line to what all points have, in place of the file's. Throws
// InputError where the grid sets that key: the points' names would tell what is not so.
void SetForAll(const std::string& assignment, SweepSpec& spec);

// The points in the grid's order: name and settings, of all points first.
std::vector<GridValue> PointsOf(const SweepSpec& spec);

// Loads every point. Throws InputError, with the place in the sweep's file, for keys that the
// settings do not know, values that they do not take, and names of nothing.
Sweep MakeSweep(const SweepSpec& spec, const std::filesystem::path& out,
                const std::string& catalog);

// The text of a sweep's file that lies in `out` and means the same.
std::string SweepText(const SweepSpec& spec, const std::filesystem::path& out);

}  // namespace pickbed
