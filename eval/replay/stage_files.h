#pragma once

// Writes all stages of a trial as files, for inspection.
//
//   attempt_00_{color,depth,ids,overlay,after}.png   depth and ids in false colors
//   attempt_00_depth_16bit.png                       depth along camera z in 0.1 mm
//   attempt_00_cloud.ply                             observed points in W
//   attempt_00_hypotheses.ply                        surface points of the estimated poses in W
//   attempt_00_scene.glb                             true poses, hypotheses, hand and cloud

#include <filesystem>

#include "eval/sweep/attempt_pictures.h"
#include "eval/trial/observer.h"

namespace pickbed::eval {

// Options of StageFiles.
struct StageFilesOptions {
  int points_per_object = 2000;  // per hypothesis in the PLY
  int glb_stride_px = 2;         // of the cloud in the GLB; the PLY contains every pixel
};

// Writes each file when its stage is reached, so a trial that crashes leaves the files of the
// earlier stages. Throws InputError if a file cannot be written.
class StageFiles : public TrialObserver {
 public:
  // Creates the folder.
  explicit StageFiles(const std::filesystem::path& folder, const StageFilesOptions& options = {});
  void OnStage(TrialStage stage, const AttemptState& attempt) override;

 private:
  std::filesystem::path PathOf(const AttemptState& attempt, const char* what) const;
  void WriteView(const AttemptState& attempt) const;
  void WriteHypotheses(const AttemptState& attempt) const;
  void WriteGrasp(const AttemptState& attempt);

  std::filesystem::path folder_;
  StageFilesOptions options_;
  BinPictures pictures_;
};

}  // namespace pickbed::eval
