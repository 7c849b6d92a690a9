#pragma once

// The pictures of picks: pick_00_color.png, _depth.png, _overlay.png and _after.png, or of lost
// ones alone pick_00_lost.jpg; of occlusion trials band_0.png, ..., too (eval/series_sheet.h).

#include <filesystem>
#include <string>

#include "eval/report/draw.h"
#include "eval/report_data.h"
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

// The overlay of each look that brought no part, as small as a report shows it. Drawn when the pick
// is over, so that one that succeeds costs nothing.
class LostPickPictures : public TrialObserver {
 public:
  explicit LostPickPictures(const std::filesystem::path& folder, const ReportOptions& options = {})
      : folder_(folder), options_(options) {}
  void OnStage(TrialStage stage, const LookState& look) override;

 private:
  std::filesystem::path folder_;
  ReportOptions options_;
  Scene before_;  // the pick
};
// Its file in a trial's folder of pictures.
std::string LostPictureName(int pick);

// What its overlay shows; from kGrasp on. Refers to the look.
OverlayInput OverlayOf(const LookState& look);

}  // namespace pickbed
