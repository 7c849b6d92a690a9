#include "eval/sweep/attempt_pictures.h"

#include <fmt/format.h>

#include "eval/summary/occlusion_sheet.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {

void WriteAttemptPictures(const std::filesystem::path& folder, int attempt,
                          const OverlayInput& input) {
  MakeFolder(folder);
  WritePng(folder / AttemptPicture(attempt, "color"), input.frame.color);
  WritePng(folder / AttemptPicture(attempt, "depth"), ColorizeDepth(input.frame.depth_m));
  WritePng(folder / AttemptPicture(attempt, "overlay"), DrawOverlay(input));
}

OverlayInput OverlayOf(const AttemptState& attempt) {
  std::vector<PoseHypothesis> estimates;
  for (const ScoredHypothesis& h : *attempt.hypotheses) estimates.push_back(h.estimate);
  return {attempt.view->frame,
          attempt.cell.camera(),
          attempt.cell.objects(),
          std::move(estimates),
          attempt.record.grasp ? &*attempt.record.grasp : nullptr,
          &attempt.gripper,
          &attempt.view->ids};
}

void PickPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  const int number = attempt.record.attempt;
  if (stage == TrialStage::kGrasp) WriteAttemptPictures(folder_, number, OverlayOf(attempt));
  if (stage == TrialStage::kGrasp && attempt.record.band >= 0) {
    WritePng(folder_ / BandTileName(attempt.record.band), BandTile(attempt));
  }
  if (stage == TrialStage::kOutcome) {
    WritePng(folder_ / AttemptPicture(number, "after"),
             attempt.cell.ColorPicture(attempt.scene, attempt.bin_index));
  }
}

void LostPickPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  if (stage != TrialStage::kOutcome || attempt.record.failure == FailureReason::kNone) return;
  const Image<Rgb8> overlay = Narrowed(DrawOverlay(OverlayOf(attempt)), size_.width_px);
  MakeFolder(folder_);
  WriteFileAtomically(folder_ / FailurePicture(attempt.record.attempt),
                      EncodeJpeg(overlay, size_.quality));
}

}  // namespace pickbed::eval
