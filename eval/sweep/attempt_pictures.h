#pragma once

// Pictures of attempts: attempt_00_color.png, _depth.png, _overlay.png and _after.png. If only
// failures are wanted, attempt_00_failed.jpg. Occlusion trials also have band_0.png, ...
// (eval/summary/occlusion_sheet.h).

#include <filesystem>
#include <string>

#include "eval/draw/overlay.h"
#include "eval/trial/observer.h"

namespace pickbed::eval {

// Writes the color, depth and overlay pictures of one attempt. Throws InputError if the folder
// cannot be created.
void WriteAttemptPictures(const std::filesystem::path& folder, int attempt,
                          const OverlayInput& input);

// Writes these pictures for each attempt of a trial, and a color picture of the bin after the pick.
class PickPictures : public TrialObserver {
 public:
  explicit PickPictures(const std::filesystem::path& folder) : folder_(folder) {}
  void OnStage(TrialStage stage, const AttemptState& attempt) override;

 private:
  std::filesystem::path folder_;
};

// Writes a small overlay of each failed attempt, in the size used by a report. It is drawn after
// the pick, so that a successful pick costs nothing.
class LostPickPictures : public TrialObserver {
 public:
  explicit LostPickPictures(const std::filesystem::path& folder, const PictureSize& size = {})
      : folder_(folder), size_(size) {}
  void OnStage(TrialStage stage, const AttemptState& attempt) override;

 private:
  std::filesystem::path folder_;
  PictureSize size_;
};

// Returns the input of the overlay of an attempt; valid from TrialStage::kGrasp on. It holds
// references into `attempt`.
OverlayInput OverlayOf(const AttemptState& attempt);

}  // namespace pickbed::eval
