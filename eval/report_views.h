#pragma once

// Trials of a run as 3D scenes: the truth, what was believed, the hand and what the camera saw at
// the first look. The scene is made again from the scenario, which gives the same bytes as in the
// run.

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
  size_t point = 0, trial = 0;  // places in the points and in the point's trials
};
// Trials whose first look is worth a view: lost ones, one of each reason before a second of any,
// and one that succeeded; `most` in all.
std::vector<ViewChoice> ChooseViews(std::span<const PointTrials> points, int most);

class ViewMaker {
 public:
  // Throws InputError for an unknown gripper or sensor.
  ViewMaker(const ScenarioSpec& spec, const ObjectSet& objects, const ReportOptions& options);
  ~ViewMaker();

  // The bytes of a GLB. Throws InputError when the scene that is made anew is not the stored
  // trial's: other meshes, another program, another kind of CPU.
  std::string Glb(const TrialResult& trial);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
