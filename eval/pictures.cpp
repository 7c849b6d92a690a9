#include "eval/pictures.h"

#include <fmt/format.h>

#include "eval/series_sheet.h"
#include "scenes/check.h"
#include "scenes/image_io.h"

namespace pickbed {
namespace {

std::filesystem::path PathOf(const std::filesystem::path& folder, int pick, const char* what) {
  return folder / fmt::format("pick_{:02}_{}.png", pick, what);
}

}  // namespace

void WriteLookPictures(const std::filesystem::path& folder, int pick, const OverlayInput& input) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  CheckInput(!error,
             fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
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

}  // namespace pickbed
