#include "grasp/completed/rehearsal.h"

#include <algorithm>
#include <cmath>

#include "grasp/execute/pick_up.h"
#include "scenes/base/error.h"
#include "scenes/geometry/mesh_levels.h"
#include "sim/convex/convex_pieces.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// Cells with less are not counted as matter between the fingers.
constexpr float kMatter = 0.2f;
// Distance of the lowest point of the hand from the plane.
constexpr double kAbovePlane_m = 0.0005;

// Returns the lowest z of the boxes in B.
double LowestPoint_m(const std::vector<AxisAlignedBox>& boxes_G, const Pose& X_BG) {
  double lowest_m = X_BG.translation().z();
  for (const AxisAlignedBox& box_G : boxes_G) {
    const double reach_m = X_BG.linear().row(2).cwiseAbs() * box_G.half_size;
    lowest_m = std::min(lowest_m, (X_BG * box_G.center).z() - reach_m);
  }
  return lowest_m;
}

// Returns the expected volume of a shape in a box of G.
double MatterIn_m3(const AxisAlignedBox& box_G, const Pose& X_WG, const OccupancyShape& shape) {
  if (shape.size == 0) return 0;
  const Pose X_GV = X_WG.inverse() * shape.X_WV, X_VG = X_GV.inverse();
  const Vector3d center_V = X_VG * box_G.center;
  const Vector3d reach_V = X_VG.linear().cwiseAbs() * box_G.half_size;
  const Eigen::Array3i low =
      ((center_V - reach_V) / shape.cell_m).array().floor().cast<int>().max(0);
  const Eigen::Array3i high =
      ((center_V + reach_V) / shape.cell_m).array().floor().cast<int>().min(shape.size - 1);
  double cells = 0;
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const float probability = shape.At(x, y, z);
        if (probability < kMatter) continue;
        const Vector3d p_G = X_GV * shape.Center_V(x, y, z);
        const Vector3d outside_m = (p_G - box_G.center).cwiseAbs() - box_G.half_size;
        if (outside_m.maxCoeff() <= 0) cells += probability;
      }
    }
  }
  return cells * std::pow(shape.cell_m, 3);
}

}  // namespace

void RehearsalOptions::Visit(SettingsVisitor& v) {
  v.Vector2("surface_levels", surface_levels, {0.01, 0.99}, "probabilities at the two surfaces");
  v.Real("tolerance_m", tolerance_m, {1e-5, 0.01}, "error of the reduced surface, m");
  v.Integer("max_pieces", max_pieces, {1, 1000}, "number of convex pieces of an object");
  v.Real("hold_s", hold_s, {0, 100}, "duration of the hold in the air, s");
  v.Real("shake_s", shake_s, {0, 100}, "duration of the shake, s");
}

Rehearsal::Rehearsal(std::span<const OccupancyShape> shapes, const Pose& X_BW,
                     const CompletedObjectOptions& assumed, double bin_friction,
                     const RehearsalOptions& options)
    : shapes_(shapes),
      X_BW_(X_BW),
      assumed_(assumed),
      bin_friction_(bin_friction),
      options_(options) {
  CheckSettings("RehearsalOptions", options_);
}

int Rehearsal::ShapeBetween(const Grasp& grasp, const Gripper& tool) const {
  const std::optional<AxisAlignedBox> region_G =
      tool.RegionBetween(tool.OpeningOrMax_m(grasp.width_m));
  if (!region_G || !grasp.X_WG.matrix().allFinite()) return -1;
  int best = -1;
  double largest_m3 = 0;
  for (size_t i = 0; i < shapes_.size(); ++i) {
    const double matter_m3 = MatterIn_m3(*region_G, grasp.X_WG, shapes_[i]);
    if (matter_m3 <= largest_m3) continue;
    largest_m3 = matter_m3;
    best = static_cast<int>(i);
  }
  return best;
}

const std::optional<CompletedObject>& Rehearsal::ObjectOf(int shape, double surface_level) {
  const auto [entry, is_new] = objects_.try_emplace({shape, surface_level});
  std::optional<CompletedObject>& object = entry->second;
  if (!is_new) return object;
  CompletedObjectOptions assumed = assumed_;
  assumed.surface_level = surface_level;
  object = MakeCompletedObject(shapes_[shape], X_BW_, assumed);
  if (!object) return object;
  ObjectModel model = *object->model;
  try {
    model.convex_pieces_O = DecomposeConvex(ReducedMesh(model.mesh_O, options_.tolerance_m),
                                            {.max_pieces = options_.max_pieces});
  } catch (const InputError&) {
    // A rehearsal is optional, so that an odd shape must not end the run.
    object.reset();
    return object;
  }
  object->model = std::make_shared<const ObjectModel>(std::move(model));
  if (object->model->convex_pieces_O.empty()) object.reset();
  return object;
}

FailureReason Rehearsal::FailureOf(const Grasp& grasp, const Gripper& tool, int shape,
                                   double surface_level) {
  const std::optional<CompletedObject>& object = ObjectOf(shape, surface_level);
  if (!object) return FailureReason::kClosedOnNothing;
  const Pose X_BG = X_BW_ * grasp.X_WG;
  const Vector3d center_B = object->X_BO.translation();
  const std::vector<AxisAlignedBox> hand_G = tool.Boxes(tool.OpeningOrMax_m(grasp.width_m));
  const double plane_m = std::min(center_B.z() + MeshBounds(object->model->mesh_O).min.z(),
                                  LowestPoint_m(hand_G, X_BG) - kAbovePlane_m);
  // P is on the plane, under the object.
  const Pose X_PB = Translation({-center_B.x(), -center_B.y(), -plane_m});
  Scene scene;
  scene.bin.inner_size_m = {1, 1, 0};
  scene.bin.friction = bin_friction_;
  PosedObject& posed = scene.objects.emplace_back();
  posed.X_WO = X_PB * object->X_BO;
  Grasp moved = grasp;
  moved.X_WG = X_PB * X_BG;
  moved.lift_aside_m.setZero();
  ExecuteOptions options;
  options.hold_s = options_.hold_s;
  options.shake_s = options_.shake_s;
  const ObjectSet objects{object->model};
  const MotionListener no_listener;  // PickUp keeps a reference
  PickUp pick(scene, objects, moved, tool, GraspTarget(posed.instance), options, no_listener);
  GraspOutcome outcome;
  const FailureReason failure = pick.Run(outcome);
  if (failure != FailureReason::kNone) return failure;
  return pick.Held().empty() ? FailureReason::kDropped : FailureReason::kNone;
}

std::optional<RehearsalFailures> Rehearsal::FailuresOf(const Grasp& grasp, const Gripper& tool) {
  const int shape = ShapeBetween(grasp, tool);
  if (shape < 0) return std::nullopt;
  double hit = 0, lost = 0, counted = 0;
  for (const double level : options_.surface_levels) {
    const FailureReason failure = FailureOf(grasp, tool, shape, level);
    const bool is_hit = failure == FailureReason::kCollision;
    const bool is_lost = failure == FailureReason::kSlipped || failure == FailureReason::kDropped;
    hit += is_hit;
    lost += is_lost;
    counted += is_hit || is_lost || failure == FailureReason::kNone;
  }
  if (counted == 0) return std::nullopt;
  return RehearsalFailures{hit / counted, lost / counted};
}

}  // namespace pickbed::grasp
