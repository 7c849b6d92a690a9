#include "eval/sweep/attempt_pictures.h"

#include <fmt/format.h>

#include "eval/draw/bin_view.h"
#include "eval/summary/occlusion_sheet.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

bool SameObjects(const Scene& a, const Scene& b) {
  return std::ranges::equal(a.objects, b.objects, [](const PosedObject& p, const PosedObject& q) {
    return p.instance == q.instance && p.object == q.object && p.X_WO.matrix() == q.X_WO.matrix();
  });
}

}  // namespace

const sim::Picture& BinPictures::Of(SimulatedCell& cell, const Scene& scene, BinIndex bin_index) {
  if (!picture_ || !SameObjects(scene, scene_)) {
    picture_ = cell.PictureOf(scene, bin_index, BinCamera(cell.camera(), cell.bin()));
    scene_ = scene;
  }
  return *picture_;
}

std::vector<OverlayPose> OverlayPoses(const std::vector<ScoredHypothesis>& hypotheses) {
  std::vector<OverlayPose> poses;
  for (const ScoredHypothesis& h : hypotheses) {
    poses.push_back({h.estimate.object, h.estimate.X_CO, h.estimate.score,
                     h.recalled >= 0 ? PoseMark::kRight : PoseMark::kWrong});
  }
  return poses;
}

std::vector<InstanceId> MissedInstances(const std::vector<InstanceRecord>& instances) {
  std::vector<InstanceId> missed;
  for (const InstanceRecord& record : instances) {
    if (!record.recalled && record.visible_fraction >= kCountedVisibility) {
      missed.push_back(record.instance);
    }
  }
  return missed;
}

OverlayInput OverlayOf(const AttemptState& attempt, const sim::Picture& picture) {
  OverlayInput input{picture.color, picture.camera.intrinsics, attempt.cell.objects(),
                     OverlayPoses(*attempt.hypotheses)};
  if (const std::optional<Grasp>& grasp = attempt.record.grasp) {
    input.hand.emplace(
        OverlayHand{*attempt.gripper, picture.camera.X_CW() * grasp->X_WG, grasp->width_m});
    if (grasp->hypothesis != kNoHypothesis) input.poses.at(grasp->hypothesis).chosen = true;
  }
  input.ids = &picture.ids;
  if (!attempt.record.pose_free) input.missed = MissedInstances(attempt.record.instances);
  input.target = attempt.record.target;
  return input;
}

void WriteAttemptPictures(const std::filesystem::path& folder, int attempt, const RgbdFrame& frame,
                          const Image<Rgb8>& overlay) {
  MakeFolder(folder);
  WritePng(folder / AttemptPicture(attempt, "color"), frame.color);
  WritePng(folder / AttemptPicture(attempt, "depth"), ColorizeDepth(frame.depth_m));
  WritePng(folder / AttemptPicture(attempt, "overlay"), overlay);
}

void FailedPickPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  if (stage == TrialStage::kScene) before_ = attempt.scene;
  if (stage != TrialStage::kOutcome || attempt.record.failure == FailureReason::kNone) return;
  SimulatedCell& cell = attempt.cell;
  const sim::Picture picture =
      cell.PictureOf(before_, attempt.bin_index,
                     WindowOf(cell.camera(), BinRegion(cell.camera(), cell.bin()), size_.width_px));
  const OverlayStyle small{.legend = false, .all_labels = false, .line_px = 2, .text_size = 0.5};
  MakeFolder(folder_);
  WriteFileAtomically(folder_ / FailurePicture(attempt.record.attempt),
                      EncodeJpeg(DrawOverlay(OverlayOf(attempt, picture), small), size_.quality));
}

void PickPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  const int number = attempt.record.attempt;
  if (stage == TrialStage::kGrasp) {
    const sim::Picture& picture = pictures_.Of(attempt.cell, attempt.scene, attempt.bin_index);
    WriteAttemptPictures(folder_, number, attempt.view->frame,
                         DrawOverlay(OverlayOf(attempt, picture)));
    if (attempt.record.band >= 0) {
      WritePng(folder_ / BandTileName(attempt.record.band), BandTile(attempt, picture));
    }
  }
  if (stage == TrialStage::kOutcome) {
    WritePng(folder_ / AttemptPicture(number, "after"),
             pictures_.Of(attempt.cell, attempt.scene, attempt.bin_index).color);
  }
  failed_.OnStage(stage, attempt);
  animation_.OnStage(stage, attempt);
}

}  // namespace pickbed::eval
