#pragma once

// The pictures of picks: pick_00_color.png, _depth.png, _overlay.png and _after.png; of occlusion
// trials band_0.png, ..., too (eval/series_sheet.h).

#include <filesystem>

#include "eval/report/draw.h"
#include "eval/trial_observer.h"

namespace pickbed {

// Colour, depth and overlay of one look. Throws InputError when the folder cannot be made.
void WriteLookPictures(const std::filesystem::path& folder, int pick, const OverlayInput& input);

// The same of each look of a trial, and the bin when the pick is over.
class PickPictures : public TrialObserver {
 public:
  explicit PickPictures(const std::filesystem::path& folder) : folder_(folder) {}
  void OnStage(TrialStage stage, const LookState& look) override;

 private:
  std::filesystem::path folder_;
};

// What its overlay shows; from kGrasp on. Refers to the look.
OverlayInput OverlayOf(const LookState& look);

}  // namespace pickbed
