#pragma once

// The robot cell of a scenario as far as it is simulated: a bin that is filled and a camera that
// looks into it. What the camera sees, with the truth beside it.

#include <memory>
#include <vector>

#include "scenes/rgbd_frame.h"
#include "scenes/scenario_spec.h"
#include "scenes/scene.h"
#include "sim/occlusion_maker.h"
#include "sim/renderer.h"
#include "sim/scene_maker.h"
#include "sim/sensor_profile.h"

namespace pickbed {

// The share of an instance that must be in view for it to count, as in BOP (Hodan et al. 2018).
inline constexpr double kCountedVisibility = 0.1;

struct View {
  RgbdFrame frame;      // what the sensor delivers
  Image<uint16_t> ids;  // truth: instance + 1, 0 = background
  // Truth: of each scene.objects[i]; 0 for one that is foreign, which does not count.
  std::vector<double> visible_fractions;
};

class VirtualCell {
 public:
  // Loads the sensor and cuts the parts into convex pieces. The renderer is made on first use.
  // Throws InputError for an unknown sensor and for one in whose range the bin's floor is not.
  VirtualCell(const ScenarioSpec& spec, const ObjectSet& objects);

  // All are functions of their arguments and the scenario's seed alone.
  CertifiedScene MakeScene(int trial) const;  // throws InputError, see sim/scene_maker.h
  // By the scenario's settings for occlusion; see sim/occlusion_maker.h for what is thrown.
  MadeSeries MakeSeries(int trial);
  View See(const Scene& scene, int trial, int look);

  // Of the scene with the looks of its trial.
  Image<Rgb8> ColorPicture(const Scene& scene, int trial);
  // By a renderer of the cell's parts and bin, for cameras besides the cell's own: `picture` tells
  // pictures of one scene apart.
  RenderedImage Render(SceneRenderer& renderer, const Scene& scene, const Camera& camera, int trial,
                       int picture) const;

  const ObjectSet& objects() const { return objects_; }       // with convex pieces
  const std::vector<int>& wanted() const { return wanted_; }  // those of them that are not foreign
  bool IsWanted(int object) const;
  int WantedIn(const Scene& scene) const;  // instances
  const Camera& camera() const { return camera_; }
  const Bin& bin() const { return bin_; }
  const SensorProfile& sensor() const { return sensor_; }

 private:
  SceneRenderer& renderer();

  uint64_t seed_;
  std::vector<int> counts_;
  std::vector<int> wanted_;
  Camera camera_;
  Bin bin_;
  DropOptions drop_;
  OcclusionSpec occlusion_;
  AppearanceRanges appearance_;
  SensorProfile sensor_;
  ObjectSet objects_;
  std::unique_ptr<SceneRenderer> renderer_;
};

}  // namespace pickbed
