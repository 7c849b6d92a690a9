#include "eval/sweep/attempt_pictures.h"

#include <fmt/format.h>

#include "eval/summary/occlusion_sheet.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

std::filesystem::path PathOf(const std::filesystem::path& folder, int attempt, const char* what) {
  return folder / fmt::format("pick_{:02}_{}.png", attempt, what);
}

}  // namespace

void WriteAttemptPictures(const std::filesystem::path& folder, int attempt,
                          const OverlayInput& input) {
  MakeFolder(folder);
  WritePng(PathOf(folder, attempt, "color"), input.frame.color);
  WritePng(PathOf(folder, attempt, "depth"), ColorizeDepth(input.frame.depth_m));
  WritePng(PathOf(folder, attempt, "overlay"), DrawOverlay(input));
}

OverlayInput OverlayOf(const AttemptState& attempt) {
  return {attempt.view->frame,    attempt.cell.camera(),
          attempt.cell.objects(), attempt.scene,
          *attempt.hypotheses,    attempt.record.grasp ? &*attempt.record.grasp : nullptr,
          &attempt.gripper,       &attempt.view->ids};
}

void PickPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  const int number = attempt.record.attempt;
  if (stage == TrialStage::kGrasp) WriteAttemptPictures(folder_, number, OverlayOf(attempt));
  if (stage == TrialStage::kGrasp && attempt.record.band >= 0) {
    WritePng(folder_ / BandTileName(attempt.record.band), BandTile(attempt));
  }
  if (stage == TrialStage::kOutcome) {
    WritePng(PathOf(folder_, number, "after"),
             attempt.cell.ColorPicture(attempt.scene, attempt.scene_number));
  }
}

std::string LostPictureName(int attempt) { return fmt::format("pick_{:02}_lost.jpg", attempt); }

void LostPickPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  if (stage == TrialStage::kGrasp) before_ = attempt.scene;
  if (stage != TrialStage::kOutcome || attempt.record.failure == FailureReason::kNone) return;
  const OverlayInput input = OverlayOf({attempt.scene_number, attempt.cell, attempt.gripper,
                                        before_, attempt.record, attempt.view, attempt.hypotheses});
  const Image<Rgb8> overlay = Narrowed(DrawOverlay(input), size_.width_px);
  MakeFolder(folder_);
  WriteFileAtomically(folder_ / LostPictureName(attempt.record.attempt),
                      EncodeJpeg(overlay, size_.quality));
}

}  // namespace pickbed::eval
