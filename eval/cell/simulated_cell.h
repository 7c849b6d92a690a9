#pragma once

// The simulated robot cell of a scenario: a bin that is filled, and a camera that looks into it.
// Images come with their ground truth.
//
//        C  x right, y down in the image, z forward (into the bin)
//   |    :    |     W z up
//   |    v z  |       ^
//   |____W____|       +--> x      W: center of the bin floor

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "eval/cell/cell_errors.h"
#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/scenario/load_objects.h"
#include "scenes/scenario/scenario_spec.h"
#include "scenes/scene.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/occlusion_series.h"
#include "sim/render/picture.h"
#include "sim/render/renderer.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {

// Minimum visible fraction of an instance that counts, as in BOP (Hodan et al. 2018).
inline constexpr double kCountedVisibility = 0.1;

// One image of the cell with its ground truth.
struct Observation {
  RgbdFrame frame;              // with the noise of the sensor and the errors of the cell
  CellCalibration calibration;  // what the cell assumes in this bin
  Image<uint16_t> ids;          // ground truth: instance + 1, 0 = background
  // Ground truth, by scene.objects[i]; 0 for distractors, which do not count.
  std::vector<double> visible_fractions;
};

class SimulatedCell {
 public:
  // Loads the sensor and prepares the objects: their convex pieces and resting directions are read
  // from the disk cache or computed. If each bin draws its objects from a pool, an object is
  // prepared when a bin first draws it. The renderer is made on first use. Throws InputError for an
  // unknown sensor, or if the bin floor is outside the sensor's range.
  SimulatedCell(const ScenarioSpec& spec, const ObjectSet& objects);

  // Replaces the seed of the scenario.
  void SetSeed(uint64_t seed);
  // Prepares all objects of a pool, for callers that use objects() before a bin draws them.
  void PrepareAllObjects() const;
  // Calls `on_prepare` after each object that is prepared from now on.
  void SetOnPrepare(ObjectProgress on_prepare) { on_prepare_ = std::move(on_prepare); }
  // Calls `on_wait` often while a bin is dropped. An exception ends the drop.
  void SetOnWait(std::function<void()> on_wait) { drop_.on_wait = std::move(on_wait); }

  // From now on, focal length, principal point and depth have no error. The pose of the camera
  // keeps its error.
  void MeasureExactly() { measures_exactly_ = true; }

  // The results of these functions depend only on the arguments, the scenario and its seed.

  // Drops the bin until it is at rest. Friction and mass deviate only after the drop, so that bins
  // stay the same in a sweep of these errors. Throws InputError, see sim/drop/certified_scene.h.
  CertifiedScene MakeScene(BinIndex bin_index) const;
  // Builds the scenes of an occlusion trial with the scenario's occlusion settings. Throws as
  // described in sim/drop/occlusion_series.h.
  MadeSeries MakeSeries(BinIndex bin_index);
  // Captures one image with sensor noise. Each `attempt` of a trial has its own random stream.
  Observation Capture(const Scene& scene, BinIndex bin_index, int attempt);

  // Renders the color image of `scene` with the random appearance of its trial.
  Image<Rgb8> ColorPicture(const Scene& scene, BinIndex bin_index);
  // Draws a picture of `scene` for people. It does not affect any image of Capture().
  sim::Picture PictureOf(const Scene& scene, BinIndex bin_index, const Camera& camera,
                         const sim::PictureOptions& options = {.scale = 1});
  // Renders with a renderer of the cell's objects and bin, for cameras other than the cell's own.
  // `picture` distinguishes the images of one scene; their background depends on it.
  RenderedImage Render(SceneRenderer& renderer, const Scene& scene, const Camera& camera,
                       BinIndex bin_index, int picture) const;

  BinErrors ErrorsOf(BinIndex bin_index) const;
  AttemptErrors ErrorsOf(BinIndex bin_index, int attempt) const;
  // Size deviation by object, see DrawSizes().
  std::vector<double> SizesOf(BinIndex bin_index) const;
  // Returns all objects in their true sizes in a bin. Physics and images use them. The objects that
  // the bin draws are prepared.
  ObjectSet TrueObjects(BinIndex bin_index) const;

  // Objects as in CAD. Estimation and planning use them. The prepared ones have convex pieces.
  const ObjectSet& objects() const { return objects_; }
  // Objects that are no distractors.
  const std::vector<ObjectId>& wanted() const { return wanted_; }
  bool IsWanted(ObjectId object) const;
  int WantedIn(const Scene& scene) const;           // number of instances that are no distractors
  const Camera& camera() const { return camera_; }  // true camera, see Observation::calibration
  const Bin& bin() const { return bin_; }
  const SensorProfile& sensor() const { return sensor_; }

 private:
  // Objects of a bin in their true sizes, and what draws them.
  struct Drawn {
    Drawn(ObjectSet true_objects, const Bin& bin)
        : objects(std::move(true_objects)), renderer(objects, bin), pictures(renderer, objects) {}
    const ObjectSet objects;
    SceneRenderer renderer;
    sim::PictureRenderer pictures;
  };
  Drawn& DrawnIn(BinIndex bin_index);
  std::vector<int> CountsIn(BinIndex bin_index) const;
  void Prepare(const std::vector<int>& counts) const;
  void AddDeviations(BinIndex bin_index, Scene& scene) const;

  uint64_t seed_;
  std::vector<int> counts_;          // in each bin without draw_
  std::string counts_place_;         // place and key of the setting that gives them
  std::vector<ObjectSpec> entries_;  // of the scenario
  int draw_ = 0;                     // instances that each bin draws; 0 = all
  std::vector<ObjectId> wanted_;
  Camera camera_;
  Bin bin_;
  DropOptions drop_;
  OcclusionSpec occlusion_;
  CellErrorsSpec errors_;
  bool measures_exactly_ = false;
  AppearanceRanges appearance_;
  SensorProfile sensor_;
  mutable ObjectSet objects_;
  mutable std::vector<bool> is_prepared_;  // by object
  ObjectProgress on_prepare_;
  std::unique_ptr<Drawn> drawn_;  // of all bins, or of drawn_bin_ if sizes deviate
  BinIndex drawn_bin_{-1};
};

}  // namespace pickbed::eval
