#include "eval/pictures.h"

#include <fmt/format.h>

#include "eval/series_sheet.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/image_io.h"

namespace pickbed {
namespace {

std::filesystem::path PathOf(const std::filesystem::path& folder, int pick, const char* what) {
  return folder / fmt::format("pick_{:02}_{}.png", pick, what);
}

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  CheckInput(!error,
             fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
}

}  // namespace

void WriteLookPictures(const std::filesystem::path& folder, int pick, const OverlayInput& input) {
  MakeFolder(folder);
  WritePng(PathOf(folder, pick, "color"), input.frame.color);
  WritePng(PathOf(folder, pick, "depth"), ColorizeDepth(input.frame.depth_m));
  WritePng(PathOf(folder, pick, "overlay"), DrawOverlay(input));
}

OverlayInput OverlayOf(const LookState& look) {
  return {look.view->frame, look.cell.camera(), look.cell.objects(),
          look.scene,       *look.hypotheses,   look.record.grasp ? &*look.record.grasp : nullptr,
          &look.gripper,    &look.view->ids};
}

void PickPictures::OnStage(TrialStage stage, const LookState& look) {
  const int pick = look.record.pick;
  if (stage == TrialStage::kGrasp) WriteLookPictures(folder_, pick, OverlayOf(look));
  if (stage == TrialStage::kGrasp && look.record.band >= 0) {
    WritePng(folder_ / BandTileName(look.record.band), BandTile(look));
  }
  if (stage == TrialStage::kOutcome) {
    WritePng(PathOf(folder_, pick, "after"), look.cell.ColorPicture(look.scene, look.scene_number));
  }
}

std::string LostPictureName(int pick) { return fmt::format("pick_{:02}_lost.jpg", pick); }

void LostPickPictures::OnStage(TrialStage stage, const LookState& look) {
  if (stage == TrialStage::kGrasp) before_ = look.scene;
  if (stage != TrialStage::kOutcome || look.record.loss == Loss::kNone) return;
  const OverlayInput input = OverlayOf({look.scene_number, look.cell, look.gripper, before_,
                                        look.record, look.view, look.hypotheses});
  const Image<Rgb8> overlay = Narrowed(DrawOverlay(input), options_.picture_width_px);
  MakeFolder(folder_);
  WriteFileAtomically(folder_ / LostPictureName(look.record.pick),
                      EncodeJpeg(overlay, options_.picture_quality));
}

}  // namespace pickbed
