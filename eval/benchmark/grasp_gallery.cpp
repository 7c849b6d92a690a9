#include "eval/benchmark/grasp_gallery.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/completion/draw.h"
#include "eval/draw/bin_view.h"
#include "eval/draw/canvas.h"
#include "eval/segments/segmentation.h"
#include "eval/sweep/attempt_pictures.h"
#include "grasp/completed/occupancy_shape.h"
#include "perception/segments/object_segments.h"

namespace pickbed::eval {
namespace {

constexpr int kTile_px = 220;
constexpr int kGap_px = 4;
constexpr double kWindow_m = 0.16;  // side of the part of the image around a grasp
constexpr Rgb8 kBlank{255, 255, 255};

// Returns a square of the picture around a point in W, kWindow_m wide at the depth of the point.
Image<Rgb8> Window(const Image<Rgb8>& picture, const Camera& camera, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = camera.X_CW() * p_W;
  const double side_px = kWindow_m * camera.intrinsics.fx() / p_C.z();
  return SquareCrop(picture, Project(camera.intrinsics, p_C), side_px, kTile_px);
}

// Returns the shape on cells with the axes of the camera.
CompletedVolume InCamera(const grasp::OccupancyShape& shape, const Pose& X_CW) {
  const double half_m = 0.5 * shape.size * shape.cell_m;
  const Pose X_VC = (X_CW * shape.X_WV).inverse();
  const Eigen::Vector3d origin_C =
      (X_CW * shape.X_WV) * Eigen::Vector3d::Constant(half_m) - Eigen::Vector3d::Constant(half_m);
  CompletedVolume volume;
  volume.origin_C = origin_C.cast<float>();
  volume.cell_m = static_cast<float>(shape.cell_m);
  volume.size = shape.size;
  for (int z = 0; z < shape.size; ++z) {
    for (int y = 0; y < shape.size; ++y) {
      for (int x = 0; x < shape.size; ++x) {
        const Eigen::Vector3d p_V = X_VC * (origin_C + shape.Center_V(x, y, z));
        const Eigen::Vector3i cell = (p_V / shape.cell_m).array().floor().cast<int>();
        volume.occupancy.push_back(shape.At(cell.x(), cell.y(), cell.z()));
      }
    }
  }
  return volume;
}

}  // namespace

const grasp::OccupancyShape* GraspedShape(const std::vector<grasp::OccupancyShape>& shapes,
                                          const Grasp& grasp) {
  const grasp::OccupancyShape* nearest = nullptr;
  double nearest_m = kInfinity;
  for (const grasp::OccupancyShape& shape : shapes) {
    const Eigen::Vector3d grasp_V = shape.X_WV.inverse() * grasp.X_WG.translation();
    for (int z = 0; z < shape.size; ++z) {
      for (int y = 0; y < shape.size; ++y) {
        for (int x = 0; x < shape.size; ++x) {
          if (shape.At(x, y, z) < grasp::kSurfaceLevel) continue;
          const double distance_m = (shape.Center_V(x, y, z) - grasp_V).norm();
          if (distance_m >= nearest_m) continue;
          nearest_m = distance_m;
          nearest = &shape;
        }
      }
    }
  }
  return nearest;
}

void GraspPictures::OnStage(TrialStage stage, const AttemptState& attempt) {
  if (stage == TrialStage::kScene) before_ = attempt.scene;
  if (stage != TrialStage::kOutcome || !attempt.record.grasp) return;
  const bool succeeded = attempt.record.failure == FailureReason::kNone;
  int& shown = succeeded ? succeeded_ : failed_;
  if (shown >= (succeeded ? kMaxSucceeded : kMaxFailed)) return;
  ++shown;
  const std::string result =
      succeeded ? "picked" : fmt::format("failed: {}", FailureName(attempt.record.failure));
  tiles_.push_back({fmt::format("{}, score {:.2f}", result, attempt.record.grasp->score), succeeded,
                    Draw(attempt)});
}

Image<Rgb8> GraspPictures::Draw(const AttemptState& attempt) const {
  SimulatedCell& cell = attempt.cell;
  const Grasp& grasp = *attempt.record.grasp;
  const Eigen::Vector3d p_W = grasp.X_WG.translation();
  const sim::Picture picture =
      cell.PictureOf(before_, attempt.bin_index, BinCamera(cell.camera(), cell.bin()));
  const OverlayStyle style{.legend = false, .all_labels = false};
  const Image<Rgb8> hand =
      Window(DrawOverlay(OverlayOf(attempt, picture), style), picture.camera, p_W);
  if (!shapes_.has_any()) return hand;
  Canvas canvas(4 * kTile_px + 3 * kGap_px, kTile_px, kBlank);
  const Observation& view = *attempt.view;
  const perception::ObjectSegments segments =
      perception::SegmentFrame(view.frame, view.calibration.Background(cell.bin()),
                               perception::SegmenterNamed(spec_.planner.segmentation).options());
  canvas.Paste(
      Window(SegmentOverlay(VisibleImage(view.frame), segments.labels), cell.camera(), p_W), 0, 0);
  const std::vector<grasp::OccupancyShape> shapes =
      shapes_.Of(cell, before_, cell.TrueObjects(attempt.bin_index), view);
  if (const grasp::OccupancyShape* shape = GraspedShape(shapes, grasp)) {
    const CompletedVolume volume = InCamera(*shape, cell.camera().X_CW());
    constexpr auto level = static_cast<float>(grasp::kSurfaceLevel);
    for (const bool from_side : {false, true}) {
      canvas.Paste(DrawVolume(volume, level, from_side, kTile_px),
                   (from_side ? 2 : 1) * (kTile_px + kGap_px), 0);
    }
  }
  canvas.Paste(hand, 3 * (kTile_px + kGap_px), 0);
  return canvas.Take();
}

}  // namespace pickbed::eval
