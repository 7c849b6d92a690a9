#include "grasp/plan/plan_stir.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "grasp/plan/clearance.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Height that a quarter of the points exceed; 0 without points.
double Surface_m(const std::vector<Vector3d>& points_W) {
  if (points_W.empty()) return 0;
  std::vector<double> heights_m;
  for (const Vector3d& p_W : points_W) heights_m.push_back(p_W.z());
  const auto quarter = heights_m.begin() + static_cast<long>(3 * heights_m.size() / 4);
  std::nth_element(heights_m.begin(), quarter, heights_m.end());
  return *quarter;
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
// number of points; the smallest one of equal ones.
double BestOffset_m(const std::vector<Vector3d>& points_W, const Vector2d& direction,
                    double half_width_m, double max_m) {
  constexpr int kSteps = 4;  // to each side
  const Vector2d left(-direction.y(), direction.x());
  double best_m = 0;
  long max_met = -1;
  for (const int step : {0, 1, -1, 2, -2, 3, -3, 4, -4}) {
    const double offset_m = max_m * step / kSteps;
    const long met = std::count_if(points_W.begin(), points_W.end(), [&](const Vector3d& p_W) {
      return std::abs(left.dot(p_W.head<2>()) - offset_m) < half_width_m;
    });
    if (met <= max_met) continue;
    max_met = met;
    best_m = offset_m;
  }
  return best_m;
}

// Orientation of a hand that points down and moves in this direction. The fingers move along their
// width, so that they do not slide apart.
Eigen::Matrix3d DownAlong(const Vector2d& direction) {
  Eigen::Matrix3d R_WG;
  R_WG.col(1) = Vector3d(direction.x(), direction.y(), 0);
  R_WG.col(2) = -Vector3d::UnitZ();
  R_WG.col(0) = R_WG.col(1).cross(R_WG.col(2));
  return R_WG;
}

// Largest coordinates of the hand's origin at which it keeps the distance `wall_m` from the walls.
Vector2d FreeRoom(const Bin& bin, const Gripper& gripper, const Eigen::Matrix3d& R_WG,
                  double tips_m, double wall_m) {
  const Vector2d half = HalfSize(gripper, bin.inner_size_m.z() - tips_m);
  const Vector2d reach = (R_WG.topLeftCorner<2, 2>().cwiseAbs() * half).array() + wall_m;
  return (0.5 * bin.inner_size_m.head<2>() - reach).cwiseMax(0);
}

// Height above the tips from which the hand descends: it passes above the rim and all points.
double Rise_m(const Bin& bin, const std::vector<Vector3d>& points_W, const Gripper& gripper,
              double tips_m) {
  double above_m = bin.inner_size_m.z();
  for (const Vector3d& p_W : points_W) above_m = std::max(above_m, p_W.z());
  return above_m - tips_m + gripper.clearance_m;
}

// Share of the floor that has points above it.
double CoveredShare(const Bin& bin, const std::vector<Vector3d>& points_W, double voxel_m) {
  std::set<std::pair<long, long>> columns;
  for (const Vector3d& p_W : points_W) {
    columns.emplace(std::lround(p_W.x() / voxel_m), std::lround(p_W.y() / voxel_m));
  }
  return static_cast<double>(columns.size()) * voxel_m * voxel_m /
         bin.inner_size_m.head<2>().prod();
}

// Points on which the fingers can press. Noise of the walls and of the rim is no place for them. A
// hand that cannot come near the walls would press on the inner side of an instance, and push it to
// the wall, so there are no such points.
std::vector<Vector3d> PressablePoints(const Bin& bin, const std::vector<Vector3d>& points_W,
                                      const Gripper& gripper, const PlanStirOptions& options) {
  const double side_m = HalfSize(gripper, bin.inner_size_m.z()).maxCoeff() + options.drag_wall_m;
  if (side_m > options.drag_side_m) return {};
  const Vector2d free = 0.5 * bin.inner_size_m.head<2>().array() - side_m;
  std::vector<Vector3d> inside;
  for (const Vector3d& p_W : points_W) {
    if ((p_W.head<2>().cwiseAbs().array() <= free.array()).all() &&
        p_W.z() < bin.inner_size_m.z() - options.depth_m) {
      inside.push_back(p_W);
    }
  }
  std::vector<Vector3d> supported;
  for (const Vector3d& p_W : inside) {
    const auto near = std::count_if(inside.begin(), inside.end(), [&](const Vector3d& other) {
      return (other - p_W).norm() < options.drag_radius_m;
    });
    if (near >= options.drag_points) supported.push_back(p_W);
  }
  return supported;
}

// Places for drags, the nearest to a wall first. They are `apart_m` or more from each other.
std::vector<Vector3d> PlacesAtWalls(const Bin& bin, std::vector<Vector3d> points_W,
                                    double apart_m) {
  const Vector2d room = 0.5 * bin.inner_size_m.head<2>();
  const auto wall_m = [&](const Vector3d& p_W) {
    return (room - p_W.head<2>().cwiseAbs()).minCoeff();
  };
  std::stable_sort(points_W.begin(), points_W.end(),
                   [&](const Vector3d& a, const Vector3d& b) { return wall_m(a) < wall_m(b); });
  std::vector<Vector3d> places;
  for (const Vector3d& p_W : points_W) {
    if (std::all_of(places.begin(), places.end(), [&](const Vector3d& other) {
          return (other - p_W).head<2>().norm() >= apart_m;
        })) {
      places.push_back(p_W);
    }
  }
  return places;
}

// Highest point within `radius_m` of a place.
Vector3d TopNear(const std::vector<Vector3d>& points_W, const Vector3d& place, double radius_m) {
  Vector3d top = place;
  for (const Vector3d& p_W : points_W) {
    if (p_W.z() > top.z() && (p_W - place).head<2>().norm() < radius_m) top = p_W;
  }
  return top;
}

// Direction away from the walls within `near_m` of a place; towards the center if there is none.
Vector2d Inward(const Bin& bin, const Vector3d& place, double near_m) {
  Vector2d inward = Vector2d::Zero();
  for (int axis = 0; axis < 2; ++axis) {
    const double wall_m = 0.5 * bin.inner_size_m[axis] - std::abs(place[axis]);
    if (wall_m < near_m) inward[axis] = place[axis] > 0 ? -1 : 1;
  }
  if (inward.isZero()) inward = -place.head<2>();
  return inward.norm() > 1e-6 ? Vector2d(inward.normalized()) : Vector2d(1, 0);
}

// Path that presses on a point near a wall and drags what is below it inward.
StirPath PlanDrag(const Bin& bin, const std::vector<Vector3d>& points_W,
                  const std::vector<Vector3d>& pressable_W, const Gripper& gripper, int number,
                  const PlanStirOptions& options) {
  const std::vector<Vector3d> places = PlacesAtWalls(bin, pressable_W, options.drag_apart_m);
  const Vector3d top = TopNear(pressable_W, places[number % places.size()], options.drag_radius_m);
  const Vector2d inward = Inward(bin, top, options.drag_near_m);
  const Eigen::Matrix3d R_WG = DownAlong(inward);
  const double tips_m = std::max(options.floor_m, top.z() - options.press_m);
  const Vector2d free = FreeRoom(bin, gripper, R_WG, tips_m, options.drag_wall_m);
  const auto inside = [&](const Vector2d& p) { return Vector2d(p.cwiseMax(-free).cwiseMin(free)); };
  const Vector2d from = inside(top.head<2>());
  const Vector2d to = inside(from + options.drag_m * inward);
  return {MakePose(R_WG, {from.x(), from.y(), tips_m}), MakePose(R_WG, {to.x(), to.y(), tips_m}),
          Rise_m(bin, points_W, gripper, tips_m)};
}

}  // namespace

void PlanStirOptions::Visit(SettingsVisitor& v) {
  v.Real("depth_m", depth_m, {0, 1}, "depth of the tips below the surface of the clutter, m");
  v.Real("floor_m", floor_m, {0, 1}, "distance between the tips and the floor, m");
  v.Real("wall_m", wall_m, {0, 1}, "distance between the hand and the walls, m");
  v.Real("voxel_m", voxel_m, {0.0005, 0.1}, "voxel size to which the cloud is thinned, m");
  v.Real("bin_band_m", bin_band_m, {0, 0.1},
         "cloud points closer than this to floor and walls belong to the bin, m");
  v.Real("drag_share", drag_share, {0, 1},
         "covered share of the floor below which the hand drags instances away from the walls");
  v.Real("drag_m", drag_m, {0, 10}, "length of the drag, m");
  v.Real("press_m", press_m, {0, 0.1}, "depth of the tips below the dragged point, m");
  v.Real("drag_wall_m", drag_wall_m, {0, 1}, "distance between the dragging hand and the walls, m");
  v.Real("drag_side_m", drag_side_m, {0, 1},
         "distance between walls and the axis of the hand within which it must come to drag, m");
  v.Real("drag_near_m", drag_near_m, {0, 10},
         "distance within which a drag is away from a wall, m");
  v.Real("drag_radius_m", drag_radius_m, {0, 1},
         "distance from a place within which the hand presses on the highest point, m");
  v.Integer("drag_points", drag_points, {1, 1000000},
            "number of points within drag_radius_m of a point on which the hand can press");
  v.Real("drag_apart_m", drag_apart_m, {0.001, 1}, "distance between places of two drags, m");
}

StirPath PlanStir(const Bin& bin, std::span<const Vector3d> cloud_W, const Gripper& gripper,
                  int number, const PlanStirOptions& options) {
  CheckSettings("PlanStirOptions", options);
  constexpr double kHeap_m = 0.3;  // a heap above the rim is no higher
  const std::vector<Vector3d> points_W =
      ThinnedCloud(cloud_W, bin, options.voxel_m, options.bin_band_m, kHeap_m);
  if (CoveredShare(bin, points_W, options.voxel_m) < options.drag_share) {
    const std::vector<Vector3d> pressable_W = PressablePoints(bin, points_W, gripper, options);
    if (!pressable_W.empty()) {
      return PlanDrag(bin, points_W, pressable_W, gripper, number, options);
    }
  }
  const Vector2d room = 0.5 * bin.inner_size_m.head<2>();
  const bool along_x = room.x() >= room.y();
  const Vector2d length = along_x ? Vector2d(room.x(), 0) : Vector2d(0, room.y());
  const Vector2d width = along_x ? Vector2d(0, room.y()) : Vector2d(room.x(), 0);
  const std::array<Vector2d, 4> ways{length, width, length + width, length - width};
  const Vector2d way = ways[number % 4] * ((number / 4) % 2 == 0 ? 1 : -1);
  const Vector2d direction = way.normalized();
  const Eigen::Matrix3d R_WG = DownAlong(direction);
  const double tips_m = std::max(options.floor_m, Surface_m(points_W) - options.depth_m);
  const Vector2d half = HalfSize(gripper, bin.inner_size_m.z() - tips_m);
  const Vector2d free = FreeRoom(bin, gripper, R_WG, tips_m, options.wall_m);
  // Share of the way that the hand may go from the center before it meets a wall.
  double share = 1;
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(way[axis]) > 1e-9) share = std::min(share, free[axis] / std::abs(way[axis]));
  }
  // Diagonals have no room beside them.
  const double max_m = number % 4 < 2 ? std::abs(R_WG.col(0).head<2>().dot(free)) : 0;
  const Vector2d left(-direction.y(), direction.x());
  const Vector2d beside = BestOffset_m(points_W, direction, half.x(), max_m) * left;
  const Vector2d from = beside - share * way, to = beside + share * way;
  return {MakePose(R_WG, {from.x(), from.y(), tips_m}), MakePose(R_WG, {to.x(), to.y(), tips_m}),
          Rise_m(bin, points_W, gripper, tips_m)};
}

}  // namespace pickbed::grasp
