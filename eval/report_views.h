#pragma once

// Looks of a run as 3D scenes: the truth, what was believed, the hand and what the camera saw. The
// scene is made again as it was (eval/look_scene.h).

#include <memory>
#include <string>
#include <vector>

#include "eval/report_data.h"
#include "grasp/gripper.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

// A layer of a view: materials whose names begin with `prefix` (eval/scene_glb.h).
struct ViewLayer {
  const char* prefix;
  const char* name;
  const char* color;  // CSS
};
std::span<const ViewLayer> ViewLayers();

struct ViewChoice {
  size_t point = 0, trial = 0, look = 0;  // places in the points, the point's trials, the trial
};
// Looks that are worth a view: lost picks, one of each reason before a second of any, and one that
// succeeded; `most` in all.
std::vector<ViewChoice> ChooseViews(std::span<const PointTrials> points, int most);

class ViewMaker {
 public:
  // Throws InputError for an unknown gripper or sensor.
  ViewMaker(const ScenarioSpec& spec, const ObjectSet& objects, const ReportOptions& options);
  ~ViewMaker();

  // The bytes of a GLB of one look. Throws what SceneOfLook throws.
  std::string Glb(const TrialResult& trial, size_t look);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
