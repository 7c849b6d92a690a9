#pragma once

// All stages of a trial as files, for a close look.
//
//   look_00_{color,depth,ids,overlay,after}.png   depth and ids in false colours
//   look_00_depth_16bit.png                       tenths of millimetres along the camera's z
//   look_00_cloud.ply                             what the camera saw, in W
//   look_00_hypotheses.ply                        points of the believed parts, in W
//   look_00_scene.glb                             truth, hypotheses, hand and cloud

#include <filesystem>

#include "eval/trial_observer.h"

namespace pickbed {

struct StageFilesOptions {
  int points_per_part = 2000;  // of each hypothesis in the PLY
  int glb_stride_px = 2;       // of the cloud in the GLB; the PLY holds every pixel
};

// Writes each file as soon as its stage is reached, so that a trial that crashes leaves those
// before. Throws InputError when a file cannot be written.
class StageFiles : public TrialObserver {
 public:
  // Makes the folder.
  explicit StageFiles(const std::filesystem::path& folder, const StageFilesOptions& options = {});
  void OnStage(TrialStage stage, const LookState& look) override;

 private:
  std::filesystem::path PathOf(const LookState& look, const char* what) const;
  void WriteView(const LookState& look) const;
  void WriteHypotheses(const LookState& look) const;
  void WriteGrasp(const LookState& look) const;

  std::filesystem::path folder_;
  StageFilesOptions options_;
};

}  // namespace pickbed
