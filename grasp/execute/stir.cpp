#include "grasp/execute/stir.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "grasp/place/hand_motion.h"
#include "sim/hands/hand.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Heights of the highest points of the instances, ascending.
std::vector<double> Tops_m(const Scene& scene, const ObjectSet& objects) {
  std::vector<double> tops_m;
  for (const PosedObject& posed : scene.objects) {
    double top_m = 0;
    for (const Vector3d& p_O : objects.at(posed.object)->mesh_O.vertices) {
      top_m = std::max(top_m, (posed.X_WO * p_O).z());
    }
    tops_m.push_back(top_m);
  }
  std::sort(tops_m.begin(), tops_m.end());
  return tops_m;
}

// Height that a quarter of the instances exceed. A single instance that leans high at a wall does
// not make the hand pass above all others.
double Surface_m(const std::vector<double>& tops_m) {
  return tops_m.empty() ? 0 : tops_m[3 * tops_m.size() / 4];
}

// Half the size of the part of the hand that is below `height_m` above its tips, in G: across and
// along the path.
Vector2d HalfSize(const Gripper& gripper, double height_m) {
  Vector2d half = Vector2d::Zero();
  for (const AxisAlignedBox& box : gripper.Boxes(0)) {
    if (-(box.center.z() + box.half_size.z()) >= height_m) continue;
    half = half.cwiseMax((box.center.cwiseAbs() + box.half_size).head<2>());
  }
  return half;
}

// Offset of the path to its left, up to `max_m` to both sides, at which the hand meets the largest
// number of instances; the smallest one of equal ones.
double BestOffset_m(const Scene& scene, const ObjectSet& objects, const Vector2d& direction,
                    double half_width_m, double max_m) {
  constexpr int kSteps = 4;  // to each side
  const Vector2d left(-direction.y(), direction.x());
  double best_m = 0;
  int max_met = -1;
  for (const int step : {0, 1, -1, 2, -2, 3, -3, 4, -4}) {
    const double offset_m = max_m * step / kSteps;
    int met = 0;
    for (const PosedObject& posed : scene.objects) {
      const ObjectModel& model = *objects.at(posed.object);
      const Vector2d center = (posed.X_WO * model.mass.com_O).head<2>();
      met += std::abs(left.dot(center) - offset_m) < half_width_m + 0.25 * model.diameter_m;
    }
    if (met <= max_met) continue;
    max_met = met;
    best_m = offset_m;
  }
  return best_m;
}

}  // namespace

void StirOptions::Visit(SettingsVisitor& v) {
  v.Real("depth_m", depth_m, {0, 1}, "depth of the tips below the surface of the clutter, m");
  v.Real("floor_m", floor_m, {0, 1}, "distance between the tips and the floor, m");
  v.Real("wall_m", wall_m, {0, 1}, "distance between the hand and the walls, m");
  v.Real("speed_mps", speed_mps, {0.001, 10}, "peak speed of the hand, m/s");
  v.Real("settle_s", settle_s, {0, 100}, "maximum time until the instances sleep again, s");
}

StirPath PlanStir(const Scene& scene, const ObjectSet& objects, const Gripper& gripper, int number,
                  const StirOptions& options) {
  const Vector2d room = 0.5 * scene.bin.inner_size_m.head<2>();
  const bool along_x = room.x() >= room.y();
  const Vector2d length = along_x ? Vector2d(room.x(), 0) : Vector2d(0, room.y());
  const Vector2d width = along_x ? Vector2d(0, room.y()) : Vector2d(room.x(), 0);
  const std::array<Vector2d, 4> ways{length, width, length + width, length - width};
  const Vector2d way = ways[number % 4] * ((number / 4) % 2 == 0 ? 1 : -1);
  const Vector2d direction = way.normalized();
  // The fingers move along their width, so that they do not slide apart.
  Eigen::Matrix3d R_WG;
  R_WG.col(1) = Vector3d(direction.x(), direction.y(), 0);
  R_WG.col(2) = -Vector3d::UnitZ();
  R_WG.col(0) = R_WG.col(1).cross(R_WG.col(2));
  const double tips_m =
      std::max(options.floor_m, Surface_m(Tops_m(scene, objects)) - options.depth_m);
  const Vector2d half = HalfSize(gripper, scene.bin.inner_size_m.z() - tips_m);
  const Vector2d reach = (R_WG.topLeftCorner<2, 2>().cwiseAbs() * half).array() + options.wall_m;
  const Vector2d free = (room - reach).cwiseMax(0);  // of the origin of the hand
  // Share of the way that the hand may go from the center before it meets a wall.
  double share = 1;
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(way[axis]) > 1e-9) share = std::min(share, free[axis] / std::abs(way[axis]));
  }
  // Diagonals have no room beside them.
  const double max_m = number % 4 < 2 ? std::abs(R_WG.col(0).head<2>().dot(free)) : 0;
  const Vector2d left(-direction.y(), direction.x());
  const Vector2d beside = BestOffset_m(scene, objects, direction, half.x(), max_m) * left;
  const Vector2d from = beside - share * way, to = beside + share * way;
  return {MakePose(R_WG, {from.x(), from.y(), tips_m}), MakePose(R_WG, {to.x(), to.y(), tips_m})};
}

ExecuteResult StirBin(const Scene& scene, const ObjectSet& objects, const Gripper& gripper,
                      int number, const StirOptions& options, const PhysicsOptions& physics,
                      const MotionListener& on_step) {
  CheckSettings("StirOptions", options);
  const StirPath path = PlanStir(scene, objects, gripper, number, options);
  AttemptWorldOptions all_move;
  all_move.all_active = true;
  AttemptWorld world(scene, objects, path.X_WG_from, {}, kNoInstance, all_move, physics);
  const std::vector<double> tops_m = Tops_m(scene, objects);
  const double above_m = std::max(scene.bin.inner_size_m.z(), tops_m.empty() ? 0 : tops_m.back());
  const double rise_m = above_m - path.X_WG_from.translation().z() + gripper.clearance_m;
  const auto raised = [&](const Pose& X_WG) { return Translation({0, 0, rise_m}) * X_WG; };
  Hand& hand = gripper.AddTo(world.physics(), 0, raised(path.X_WG_from));
  hand.HoldOpening(0);
  int steps = 0;
  const auto step = [&] {
    world.Step();
    ++steps;
    if (on_step) on_step({steps * world.physics().step_s(), world, hand, nullptr});
  };
  const auto move = [&](const Pose& from, const Pose& to) {
    const double distance_m = (to.translation() - from.translation()).norm();
    const int count = world.Steps(MinimumJerkSeconds(distance_m, options.speed_mps));
    for (int i = 1; i <= count; ++i) {
      hand.MoveTo(Between(from, to, MinimumJerk(static_cast<double>(i) / count)));
      step();
    }
  };
  move(raised(path.X_WG_from), path.X_WG_from);
  move(path.X_WG_from, path.X_WG_to);
  move(path.X_WG_to, raised(path.X_WG_to));
  const int maximum = world.Steps(options.settle_s);
  for (int i = 0; i < maximum && !world.physics().AllAsleep(); ++i) {
    hand.MoveTo(raised(path.X_WG_to));
    step();
  }
  ExecuteResult result;
  const bool failed = world.physics().BlewUp();
  result.outcome.failure = failed ? FailureReason::kPhysicsFailed : FailureReason::kStirred;
  result.after = failed ? scene : world.Remaining({});
  if (!failed) {
    result.outcome.neighbors_displaced =
        world.Displaced(ExecuteOptions().displaced_m, {}, kNoInstance);
  }
  return result;
}

}  // namespace pickbed::grasp
