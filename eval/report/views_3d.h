#pragma once

// Attempts of a run as 3D scenes: true poses, estimated poses, hand and observed points. The scene
// is reconstructed from the stored trial (eval/trial/recorded_scene.h).

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "eval/report/run_statistics.h"
#include "grasp/gripper.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// A layer of a view: all materials whose names begin with `prefix` (eval/export/scene_glb.h).
struct ViewLayer {
  const char* prefix;
  const char* name;
  const char* color;         // CSS
  bool is_optional = false;  // only in some views, and hidden in the others
};
// Returns all layers.
std::span<const ViewLayer> ViewLayers();

// An attempt to be shown.
struct ViewChoice {
  size_t configuration = 0, trial = 0,
         attempt = 0;  // indices of configuration, its trial, its attempt
};
// Returns at most `maximum` attempts to be shown. They are failures, one of each reason before a
// second of any, followed by one success. With `suits`, all of them pass it.
std::vector<ViewChoice> ChooseViews(std::span<const ConfigurationTrials> configurations,
                                    int maximum,
                                    const std::function<bool(const ViewChoice&)>& suits = {});

// Creates the views of one configuration.
class ViewMaker {
 public:
  // Throws InputError for an unknown gripper or sensor.
  ViewMaker(const ScenarioSpec& spec, const ObjectSet& objects, const ReportOptions& options);
  ~ViewMaker();

  // Returns the bytes of a GLB file of one attempt. Throws like SceneOfAttempt.
  std::string Glb(const TrialResult& trial, size_t attempt);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::eval
