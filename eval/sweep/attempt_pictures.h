#pragma once

// Pictures of attempts: attempt_00_color.png and _depth.png are the images of the sensor.
// attempt_00_overlay.png and _after.png are pictures for people (sim/render/picture.h) of the bin
// before the pick, with the estimated poses, and after it. A failed attempt also has the small
// attempt_00_failed.jpg. attempt_00_pick.glb is the animated pick. Occlusion trials also have
// band_0.png, ... (eval/summary/occlusion_sheet.h).

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/draw/overlay.h"
#include "eval/export/pick_animation.h"
#include "eval/trial/observer.h"

namespace pickbed::eval {

// Pictures of the bin for people, by the cell's camera. A picture of the same scene as before is
// not drawn again.
class BinPictures {
 public:
  const sim::Picture& Of(SimulatedCell& cell, const Scene& scene, BinIndex bin_index);

 private:
  std::optional<sim::Picture> picture_;
  Scene scene_;
};

// Returns the poses of an overlay. A pose is right if it recalls an instance.
std::vector<OverlayPose> OverlayPoses(const std::vector<ScoredHypothesis>& hypotheses);
// Returns the visible instances without a right pose.
std::vector<InstanceId> MissedInstances(const std::vector<InstanceRecord>& instances);

// Returns the input of the overlay of an attempt on a picture of the scene before the pick; valid
// from TrialStage::kGrasp on. It holds references into its arguments.
OverlayInput OverlayOf(const AttemptState& attempt, const sim::Picture& picture);

// Writes the color and depth images of a frame and the overlay. Throws InputError if the folder
// cannot be created.
void WriteAttemptPictures(const std::filesystem::path& folder, int attempt, const RgbdFrame& frame,
                          const Image<Rgb8>& overlay);

// Writes a small overlay of each failed attempt, in the size used by a report. It is drawn after
// the pick, so that a successful pick costs nothing.
class FailedPickPictures : public TrialObserver {
 public:
  explicit FailedPickPictures(const std::filesystem::path& folder, const PictureSize& size = {})
      : folder_(folder), size_(size) {}
  void OnStage(TrialStage stage, const AttemptState& attempt) override;

 private:
  std::filesystem::path folder_;
  PictureSize size_;
  Scene before_;  // the scene before the pick
};

// Writes all pictures of each attempt of a trial, and the animation of each pick.
class PickPictures : public TrialObserver {
 public:
  explicit PickPictures(const std::filesystem::path& folder)
      : folder_(folder), failed_(folder), animation_(folder, /*with_gif=*/false) {}
  void OnStage(TrialStage stage, const AttemptState& attempt) override;
  MotionListener ListenToMotion() override { return animation_.ListenToMotion(); }

 private:
  std::filesystem::path folder_;
  BinPictures pictures_;
  FailedPickPictures failed_;
  PickAnimation animation_;
};

}  // namespace pickbed::eval
