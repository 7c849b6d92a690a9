#include "eval/replay_files.h"

#include <fmt/format.h>

#include "eval/command_line.h"
#include "eval/pictures.h"
#include "eval/scene_glb.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "scenes/ply_writer.h"

namespace pickbed {
namespace {

void WritePly(const std::filesystem::path& path, const GlbCloud& cloud) {
  WriteFileAtomically(path, PlyCloudBytes(cloud.points_W, cloud.rgb));
}

}  // namespace

StageFiles::StageFiles(const std::filesystem::path& folder, const StageFilesOptions& options)
    : folder_(folder), options_(options) {
  MakeFolder(folder);
}

std::filesystem::path StageFiles::PathOf(const LookState& look, const char* what) const {
  return folder_ / fmt::format("look_{:02}_{}", look.record.pick, what);
}

void StageFiles::OnStage(TrialStage stage, const LookState& look) {
  switch (stage) {
    case TrialStage::kScene:
      return;  // the GLB shows it, together with what was believed of it
    case TrialStage::kImage:
      return WriteView(look);
    case TrialStage::kHypotheses:
      return WriteHypotheses(look);
    case TrialStage::kGrasp:
      return WriteGrasp(look);
    case TrialStage::kOutcome:
      WritePng(PathOf(look, "after.png"), look.cell.ColorPicture(look.scene, look.scene_number));
  }
}

void StageFiles::WriteView(const LookState& look) const {
  const RgbdFrame& frame = look.view->frame;
  WritePng(PathOf(look, "color.png"), frame.color);
  WritePng(PathOf(look, "depth.png"), ColorizeDepth(frame.depth_m));
  WriteDepthPng(PathOf(look, "depth_16bit.png"), frame.depth_m);
  WritePng(PathOf(look, "ids.png"), ColorizeIds(look.view->ids));
  WritePly(PathOf(look, "cloud.ply"), ObservedCloud(frame, look.cell.camera().X_WC, 1));
}

void StageFiles::WriteHypotheses(const LookState& look) const {
  WritePly(PathOf(look, "hypotheses.ply"),
           BelievedCloud(look.cell.objects(), look.record.hypotheses, options_.points_per_part));
}

void StageFiles::WriteGrasp(const LookState& look) const {
  WritePng(PathOf(look, "overlay.png"), DrawOverlay(OverlayOf(look)));
  const GlbCloud cloud =
      ObservedCloud(look.view->frame, look.cell.camera().X_WC, options_.glb_stride_px);
  const Grasp* grasp = look.record.grasp ? &*look.record.grasp : nullptr;
  WriteFileAtomically(PathOf(look, "scene.glb"),
                      SceneGlb({look.scene, look.cell.objects(), look.record.hypotheses, grasp,
                                &look.gripper, &cloud}));
}

}  // namespace pickbed
