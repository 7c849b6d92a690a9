#pragma once

// The scenario: the text file in which a user describes what to build and run. See scenes/presets
// for examples.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/settings.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/camera.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/appearance_ranges.h"
#include "scenes/scenario/cell_errors.h"
#include "scenes/scenario/occlusion_spec.h"
#include "scenes/scenario/planner_spec.h"
#include "scenes/scenario/policy.h"
#include "scenes/scenario/region_spec.h"
#include "scenes/scenario/tool_names.h"

namespace pickbed::scenes {

// An object and its number of instances. It is either a name of the catalog, or an own name with
// `mesh`, `unit`, and `mass_kg` or `density_kgpm3`. A range of seeds in the name of a sampled shape
// gives several objects, and so does a pattern with * or ? in the file name of the mesh, see
// scenes/scenario/object_pool.h.
struct ObjectSpec {
  std::string name;
  int count = 1;
  std::string mesh;          // path, relative to the scenario file; empty = from the catalog
  std::string unit = "m";    // of the mesh
  double mass_kg = 0;        // only with a mesh
  double density_kgpm3 = 0;  // of a uniform solid, instead of the mass; only with a mesh
  double friction = 0.5;     // against a gripper pad; only with a mesh
  bool distractor = false;   // in the bin, but unknown to the estimator and not wanted
  void Visit(SettingsVisitor& v);
};

// The depth camera: image size, focal length, position and viewing target.
struct CameraSpec {
  int width = 640;
  int height = 480;
  double focal_px = 680;
  double focal_y_px = 0;                  // 0 = same as focal_px
  Eigen::Vector2d principal_px{-1, -1};   // pixel centers are integers; negative = image center
  Eigen::Vector3d eye_m{0, -0.12, 0.85};  // in W
  Eigen::Vector3d target_m{0, 0, 0.03};   // in W
  void Visit(SettingsVisitor& v);
};

// Search mode "first": a few sure poses on top of the pile.
struct FirstPosesSpec {
  int poses = 5;            // the search ends when so many poses are found
  double confidence = 0.9;  // minimum score of a pose that counts
  void Visit(SettingsVisitor& v);
};

// Value of estimator.completion without additional poses.
inline constexpr char kNoCompletion[] = "none";

// The pose estimator and its settings.
struct EstimatorSpec {
  std::string name = "descriptor";
  std::string model;          // name in assets/models or a path; empty = the shipped model
  std::string mode = "fast";  // fast | accurate | first; ppf also has verified
  FirstPosesSpec first;
  double min_score = 0.5;  // hypotheses with a lower score are not reported
  // Calibration file of `pickbed calibrate`; empty = the scores are used as they are. The scores
  // become probabilities of `calibrated_to`: pose_right | pick_succeeds.
  std::string calibration;
  std::string calibrated_to = "pose_right";
  // descriptor only: method that completes occluded segments for additional poses
  std::string completion = kNoCompletion;
  std::string completion_model = "completion";  // of method network
  double noise_mm = 0;   // oracle only: standard deviation of the position, each axis
  double noise_deg = 0;  // oracle only: standard deviation of the rotation angle
  // process only, see scenes/plugin/plugin_client.h
  std::vector<std::string> command;    // program and arguments
  std::string connect;                 // host:port of a running program, instead of a command
  double timeout_s = 60;               // maximum time for each answer
  std::string scores = "probability";  // probability | raw: any scale
  void Visit(SettingsVisitor& v);
};
// Returns whether the scores are not probabilities.
inline bool HasRawScores(const EstimatorSpec& spec) { return spec.scores == "raw"; }

// The bin: a box with dimensions, a mesh, or a file that gives them.
struct BinSpec {
  // assets/bins/NAME.yaml or a path. Keys given in the scenario override the keys of this file.
  std::string name;
  // Mesh of any shape, see scenes/bin/bin_shape.h; relative to the file that names it.
  std::string mesh;
  std::string unit = "m";                          // of the mesh
  Eigen::Vector3d inner_size_m{0.40, 0.30, 0.15};  // measured if only a mesh is given
  double wall_m = 0.006;                           // measured if only a mesh is given
  double friction = 0.5;                           // the bin's factor in PairFriction()
  std::shared_ptr<const BinShape> shape;           // of the mesh; not a setting
  void Visit(SettingsVisitor& v);
};

// All settings of a scenario.
struct ScenarioSpec {
  uint64_t seed = 0;
  int trials = 1;  // number of bins
  // A run, or a configuration of a sweep, ends early when the confidence interval of its pick
  // success is at most this wide, 0 to 1; 0 = never. See eval/stats/sequential_stop.h.
  double stop_width = 0;
  BinSpec bin;
  std::vector<ObjectSpec> objects;
  // Number of wanted instances that each bin draws from all instances of the objects, without
  // repetition; 0 = every bin gets all. Distractors keep their counts.
  int draw = 0;
  std::string arrangement = "pile";  // pile | packed | heap, see sim/drop/drop.h
  // Mean height of the pile over the inner height of the bin. The counts of the objects are then
  // relative, and sim/drop/fill_counts.h finds the numbers of instances. 0 = the counts are used.
  double fill = 0;
  CameraSpec camera;
  std::string sensor = "structured_light";  // assets/sensors/NAME.yaml or a path
  AppearanceRanges appearance = FixedAppearance();
  EstimatorSpec estimator;
  std::string refiner = "pcl_icp";  // a row of RefinerTable(), see perception/icp
  ToolNames gripper = "jaw_8cm";    // assets/grippers/NAME.yaml or paths
  PlannerSpec planner;
  PolicySpec policy;
  OcclusionSpec occlusion;
  CellErrorsSpec cell;
  CycleSpec cycle;
  RegionSpec roi;                // region of interest of the estimator
  std::filesystem::path folder;  // of the scenario file, for relative paths; not a setting
  KeyPlaces places;              // file and line of each given key; not a setting

  void Visit(SettingsVisitor& v);

  // Returns the beginning of an error about a key, such as "demo.yaml:12: gripper". It is only the
  // key if the key was not given.
  std::string At(const std::string& key) const;

  // Checks every value against its range, and what needs several fields but no mesh. At least one
  // object must be wanted (not `distractor`). Object names must be unique, and a mass is given
  // exactly for meshes. The camera must be outside the bin's walls, above its floor and look at it.
  // The ranges of appearance and occlusion must be valid, and no position error of the cell may be
  // larger than the bin. Throws InputError.
  void Validate() const;
};

// Calls `work` and returns its result. An InputError of it, such as an unknown name, is rethrown
// with the place where the key was given at its beginning.
template <typename Work>
auto WithSettingsKey(const ScenarioSpec& spec, const std::string& key, Work work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(spec.At(key) + ": " + error.what());
  }
}

// Reads a scenario file, applies the "key=value" overrides in order, adds the bin's file and mesh,
// and validates the result. Throws InputError.
ScenarioSpec LoadScenario(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides = {});
// Same for the text of a file in `folder`; errors use `name` as the file name.
ScenarioSpec LoadScenarioText(const std::string& yaml, const std::filesystem::path& folder,
                              const std::string& name);

std::vector<std::string> BinNames();  // names in assets/bins, sorted

// Loads a bin by its NAME in assets/bins or a path that ends in .yaml, with the shape of its mesh.
// Throws InputError for an unknown name, a bad value or a mesh that is not a bin.
BinSpec LoadBin(const std::string& name_or_path);

// Returns the bin of the scenario with its inner size (m), walls, friction and mesh.
Bin BinOf(const ScenarioSpec& spec);
// Returns the camera of the scenario: intrinsics (px) and X_WC.
Camera CameraOf(const ScenarioSpec& spec);

}  // namespace pickbed::scenes
