#pragma once

// Executes the picks that follow from the poses of a method, in the clutter that an image shows.
//
// Every pick starts from the stored scene of the image, so the picks of one image do not affect
// each other. The planner is the one of a run: it gets the depth image of the data set, the
// calibrated camera, the bin and all poses of the method as obstacles. It chooses the best grasp on
// a pose. The next pick may use only poses at other places: further than a quarter of the diameter
// from the poses that were picked. As many picks are requested as the image has instances that are
// at least 10 % visible, but at most `picks`.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "eval/execution/methods.h"
#include "eval/execution/pick_rows.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Returns the number of picks that are requested in an image. `is_wanted`: by object, false for
// distractors.
int RequestedPicks(const ImageTruth& image, const std::vector<bool>& is_wanted, int picks);

// Returns the scenario without the settings of its estimator, which an execution does not use.
ScenarioSpec WithoutEstimator(ScenarioSpec spec);

class ImageExecutor {
 public:
  // `scenes` must outlive this object. `root` is the folder of the data set; its meshes are used
  // for the BOP errors. A planner that is a program writes its standard error into `log_dir`, if it
  // is not empty; `on_warning` receives the lines about its failures. Throws InputError as
  // TrialSetup().
  ImageExecutor(const ScenarioSpec& spec, const ObjectSet& objects,
                const std::filesystem::path& root, const ExecutedScenes& scenes, int picks,
                const std::filesystem::path& log_dir = {},
                const std::function<void(const std::string&)>& on_warning = {});
  ~ImageExecutor();

  // Executes the requested picks of each method in one image. Returns them by method, then by pick.
  std::vector<ExecutedPick> Execute(int scene_id, int image_id, const std::vector<Method>& methods);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::eval
