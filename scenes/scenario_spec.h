#pragma once

// What to build and run: the text file that a user writes. See scenes/presets for examples.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scenes/appearance_ranges.h"
#include "scenes/bin.h"
#include "scenes/camera.h"
#include "scenes/check.h"
#include "scenes/object_catalog.h"
#include "scenes/occlusion_spec.h"
#include "scenes/policy.h"
#include "scenes/settings.h"

namespace pickbed {

// One kind of part and how many of it. Either a name of the catalog, or a name of your own and
// `mesh`, `unit` and `mass_kg`.
struct PartSpec {
  std::string name;
  int count = 1;
  std::string mesh;  // path, relative to the scenario file; empty = from the catalog
  std::string unit = "m";
  double mass_kg = 0;
  double friction = 0.5;
  bool foreign = false;  // in the bin, but neither known to the estimator nor wanted
  void Visit(SettingsVisitor& v);
};

struct CameraSpec {
  int width = 640;
  int height = 480;
  double focal_px = 680;
  double focal_y_px = 0;                  // 0 = as focal_px
  Eigen::Vector2d principal_px{-1, -1};   // pixel centres are whole numbers; negative = the middle
  Eigen::Vector3d eye_m{0, -0.12, 0.85};  // in W
  Eigen::Vector3d target_m{0, 0, 0.03};   // in W
  void Visit(SettingsVisitor& v);
};

struct EstimatorSpec {
  std::string name = "descriptor";
  std::string model;          // name under assets/models or a path; empty = the shipped one
  std::string mode = "fast";  // fast | hard; ppf also verified
  double min_score = 0.5;     // hypotheses below are not reported
  double noise_mm = 0;        // oracle only: sigma of each axis of the position
  double noise_deg = 0;       // oracle only: sigma of the rotation angle
  void Visit(SettingsVisitor& v);
};

struct BinSpec {
  std::string
      name;  // assets/bins/NAME.yaml or a path; keys that are given here go before the file's
  std::string mesh;  // of any shape, see scenes/bin_shape.h; relative to the file that names it
  std::string unit = "m";
  Eigen::Vector3d inner_size_m{0.40, 0.30, 0.15};  // where a mesh is given but not this: measured
  double wall_m = 0.006;                           // likewise
  double friction = 0.5;
  std::shared_ptr<const BinShape> shape;  // of the mesh; not a setting
  void Visit(SettingsVisitor& v);
};

// What may polish reported poses, with one line of help each.
struct RefinerName {
  const char* name;
  const char* help;
};
std::span<const RefinerName> RefinerNames();

struct ScenarioSpec {
  uint64_t seed = 0;
  int trials = 1;
  // A run, or point of a sweep, ends early once the interval of its pick success is no wider, from
  // 0 to 1; 0 = never. See eval/sequential_stop.h.
  double stop_width = 0;
  BinSpec bin;
  std::vector<PartSpec> objects;
  std::string arrangement = "pile";  // pile | packed | heap, see sim/drop.h
  CameraSpec camera;
  std::string sensor = "structured_light";  // assets/sensors/NAME.yaml or a path
  AppearanceRanges appearance = FixedAppearance();
  EstimatorSpec estimator;
  std::string refiner = "pcl_icp";  // a row of RefinerNames()
  std::string gripper = "jaw_8cm";  // assets/grippers/NAME.yaml or a path
  PolicySpec policy;
  OcclusionSpec occlusion;
  CycleSpec cycle;
  std::filesystem::path folder;  // of the scenario file, for relative paths; not a setting
  KeyPlaces places;              // of the keys that were given; not a setting

  void Visit(SettingsVisitor& v);

  // "demo.yaml:12: gripper": how errors about a key begin; the key alone where it was not given.
  std::string At(const std::string& key) const;

  // Cross-field checks that need no mesh: at least one object, positive counts, camera outside the
  // bin's walls, not under its floor and looking at it, ranges of the appearance the right way
  // round. Throws InputError.
  void Validate() const;
};

// What `work` returns; an InputError of it, a name that is unknown for instance, begins with where
// the key was given.
template <typename Work>
auto BlameKey(const ScenarioSpec& spec, const std::string& key, Work work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(spec.At(key) + ": " + error.what());
  }
}

// Reads, applies the "key=value" overrides in order, validates. Throws InputError.
ScenarioSpec LoadScenario(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides = {});
// The same of the text of a file that would lie in `folder`; `name` stands for it in errors.
ScenarioSpec LoadScenarioText(const std::string& yaml, const std::filesystem::path& folder,
                              const std::string& name);

// Loads each part; throws InputError when one is unknown, broken, or larger than the bin, or when
// all together are more than a heap in it can hold.
ObjectSet LoadObjects(const ScenarioSpec& spec, const ObjectCatalog& catalog);

std::vector<std::string> BinNames();  // of assets/bins, sorted

// NAME of assets/bins, or a path ending in .yaml, with the shape of its mesh. Throws InputError for
// an unknown name, a bad value or a mesh that is no bin.
BinSpec LoadBin(const std::string& name_or_path);

Bin BinOf(const ScenarioSpec& spec);
Camera CameraOf(const ScenarioSpec& spec);

}  // namespace pickbed
