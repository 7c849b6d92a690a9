#include "eval/replay/stage_files.h"

#include <fmt/format.h>

#include "eval/export/scene_glb.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/scene_export.h"

namespace pickbed::eval {
namespace {

void WritePly(const std::filesystem::path& path, const GlbCloud& cloud) {
  WriteFileAtomically(path, PlyCloudBytes(cloud.points_W, cloud.rgb));
}

}  // namespace

StageFiles::StageFiles(const std::filesystem::path& folder, const StageFilesOptions& options)
    : folder_(folder), options_(options) {
  MakeFolder(folder);
}

std::filesystem::path StageFiles::PathOf(const AttemptState& attempt, const char* what) const {
  return folder_ / fmt::format("attempt_{:02}_{}", attempt.record.attempt, what);
}

void StageFiles::OnStage(TrialStage stage, const AttemptState& attempt) {
  switch (stage) {
    case TrialStage::kScene:
      return;  // the GLB of a later stage shows it together with the estimated poses
    case TrialStage::kImage:
      return WriteView(attempt);
    case TrialStage::kHypotheses:
      return WriteHypotheses(attempt);
    case TrialStage::kGrasp:
      return WriteGrasp(attempt);
    case TrialStage::kOutcome:
      WritePng(PathOf(attempt, "after.png"),
               pictures_.Of(attempt.cell, attempt.scene, attempt.bin_index).color);
  }
}

void StageFiles::WriteView(const AttemptState& attempt) const {
  const RgbdFrame& frame = attempt.view->frame;
  WritePng(PathOf(attempt, "color.png"), frame.color);
  WritePng(PathOf(attempt, "depth.png"), ColorizeDepth(frame.depth_m));
  WriteDepthPng(PathOf(attempt, "depth_16bit.png"), frame.depth_m);
  WritePng(PathOf(attempt, "ids.png"), ColorizeIds(attempt.view->ids));
  WritePly(PathOf(attempt, "cloud.ply"),
           ObservedCloud(frame, attempt.view->calibration.camera.X_WC(), 1));
}

void StageFiles::WriteHypotheses(const AttemptState& attempt) const {
  WritePly(PathOf(attempt, "hypotheses.ply"),
           EstimatedCloud(attempt.cell.objects(), attempt.record.hypotheses,
                          options_.points_per_object));
}

void StageFiles::WriteGrasp(const AttemptState& attempt) {
  WritePng(PathOf(attempt, "overlay.png"),
           DrawOverlay(
               OverlayOf(attempt, pictures_.Of(attempt.cell, attempt.scene, attempt.bin_index))));
  const GlbCloud cloud = ObservedCloud(attempt.view->frame, attempt.view->calibration.camera.X_WC(),
                                       options_.glb_stride_px);
  const ObjectSet true_objects = attempt.cell.TrueObjects(attempt.bin_index);
  const Grasp* grasp = attempt.record.grasp ? &*attempt.record.grasp : nullptr;
  WriteFileAtomically(PathOf(attempt, "scene.glb"),
                      SceneGlb({attempt.scene, attempt.cell.objects(), attempt.record.hypotheses,
                                grasp, attempt.gripper, &cloud, &true_objects}));
}

}  // namespace pickbed::eval
