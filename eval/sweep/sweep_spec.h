#pragma once

// SWEEP.yaml: the settings that a sweep varies.
//
//   scenario: bin_bracket          # a preset, or a file (relative to this one)
//   trials: 40                     # bins per configuration; default: as in the scenario
//   set: {gripper: cup_30mm}       # settings of all configurations
//   grid:                          # Cartesian product, the first key varies slowest
//     sensor: [ideal, time_of_flight]
//     seed: 1..3                   # integers from 1 to 3
//     method:                      # several keys changed together, with user-defined names
//       ppf: {estimator.name: ppf, estimator.mode: verified}      # configuration method=ppf
//       learned: {estimator.name: descriptor}
//     pair: [{sensor: ideal, refiner: none}, {sensor: time_of_flight}]    # named by their settings
//   occlusion: {...}               # settings of that group, for all configurations
//   slurm: {...}                   # see eval/sweep/slurm.h
//
// Any key of `pickbed list settings` can be used in set and grid.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/sweep/slurm.h"
#include "eval/sweep/sweep.h"
#include "scenes/base/settings_tree.h"

namespace pickbed::eval {

// One value of an axis: the settings that it changes.
struct GridValue {
  std::string name;  // such as "estimator.name=ppf,estimator.mode=verified"
  std::vector<PlacedSetting> settings;
};
// A key of the grid with its values.
struct GridAxis {
  std::string key;
  std::vector<GridValue> values;
};

// Content of a sweep file.
struct SweepSpec {
  std::string name;      // name of the file without folder and extension
  std::string scenario;  // preset name or absolute path
  std::optional<int> trials;
  std::vector<PlacedSetting> set;
  std::vector<GridAxis> grid;
  SlurmOptions slurm;
  std::string grid_text;  // grid as written in the file, in YAML flow style
};

// A key of a sweep file.
struct SweepKey {
  const char* name;
  const char* value;  // what to write, in words
  const char* help;
};
// Returns all keys of a sweep file.
std::span<const SweepKey> SweepKeys();

// Reads a sweep file. Throws InputError with file and line for an unknown key, an empty or
// malformed grid, and a key that is set by two axes. MakeSweep checks the keys and values of the
// grid.
SweepSpec LoadSweepSpec(const std::filesystem::path& file);

// Adds a "key=value" setting for all configurations; it replaces the same key in the file. Throws
// InputError if the grid sets that key, because the configuration names would be wrong.
void SetForAll(const std::string& assignment, SweepSpec& spec);

// Returns the configurations in grid order, each with its name and settings. The common settings
// come first.
std::vector<GridValue> GridConfigurations(const SweepSpec& spec);

// Loads the scenario of every configuration. Throws InputError, with the place in the sweep file,
// for unknown keys, invalid values, and unknown names.
Sweep MakeSweep(const SweepSpec& spec, const std::filesystem::path& out,
                const std::string& catalog);

// Returns the text of an equivalent sweep file located in `out`.
std::string SweepText(const SweepSpec& spec, const std::filesystem::path& out);

// Throws InputError if `out` contains a sweep file with other settings than `yaml`. The Slurm
// settings are not compared. The file may be from an earlier version.
void RequireNoOtherSweep(const std::filesystem::path& out, const std::string& yaml);

}  // namespace pickbed::eval
