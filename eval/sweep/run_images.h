#pragma once

// The images of a picking run as a BOP data set: one scene per trial, one image per attempt that
// captured one. So a data set shows the clutter as it shrinks. Scene id - 1 is the number of the
// bin, and the image id is the number of the attempt. Each image has its stored scene, for `pickbed
// execute`.
//
// Color, depth, intrinsics and camera pose are the ones that the cell has, with its errors. The
// ground truth is the true pose in the true camera frame. The meshes have nominal sizes.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "eval/bop/stored_scenes.h"
#include "eval/bop/write_scene.h"
#include "eval/trial/observer.h"
#include "scenes/scenario/scenario_spec.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {

inline constexpr char kRunSplit[] = "test";  // folder of the scenes

// Writes the scene folder of one trial. The folder gets its name when the trial is complete.
class RunImageWriter : public TrialObserver {
 public:
  // `root`: folder of the data set.
  RunImageWriter(const std::filesystem::path& root, uint64_t seed, BinIndex bin_index);
  ~RunImageWriter() override;
  void OnStage(TrialStage stage, const AttemptState& attempt) override;
  // Completes the scene folder; replaces the one of an earlier try of the trial. A trial without
  // an image has no folder.
  void Finish();

 private:
  void Begin(SimulatedCell& cell);

  std::filesystem::path folder_, unfinished_;
  std::optional<SceneWriter> writer_;
  std::unique_ptr<SceneRenderer> renderer_;  // for the masks
  ObjectSet objects_;
  StoredScenes stored_;
};

// Creates the folder of the data set with the scenario, the models and the camera. Notes its path
// in the results folder (kImageFolderFile). `finished`: trials of the results folder that have an
// image. Throws InputError if the data set holds
// - scenes of other settings, or scenes without `resume`,
// - scenes of other results: no trial is in `finished`, or it is not the data set of this results
//   folder and has scenes of further trials, which FinishRunDataset() would remove,
// - no scene of a trial of `finished`, because it ran without the data set.
void BeginRunDataset(const ScenarioSpec& spec, const ObjectSet& objects,
                     const std::filesystem::path& root, const std::filesystem::path& results,
                     const std::string& identity, bool resume, const std::vector<int>& finished);
// Writes the targets files and the cards. Removes scenes of other trials than `finished`, which an
// early stop has dropped.
void FinishRunDataset(const ScenarioSpec& spec, const ObjectSet& objects,
                      const std::filesystem::path& root, const std::string& identity,
                      const std::vector<int>& finished);

}  // namespace pickbed::eval
