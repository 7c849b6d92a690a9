#include "grasp/plan/plan_stir.h"

#include <algorithm>
#include <array>
#include <cmath>
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

}  // namespace

void PlanStirOptions::Visit(SettingsVisitor& v) {
  v.Real("depth_m", depth_m, {0, 1}, "depth of the tips below the surface of the clutter, m");
  v.Real("floor_m", floor_m, {0, 1}, "distance between the tips and the floor, m");
  v.Real("wall_m", wall_m, {0, 1}, "distance between the hand and the walls, m");
  v.Real("voxel_m", voxel_m, {0.0005, 0.1}, "voxel size to which the cloud is thinned, m");
  v.Real("bin_band_m", bin_band_m, {0, 0.1},
         "cloud points closer than this to floor and walls belong to the bin, m");
}

StirPath PlanStir(const Bin& bin, std::span<const Vector3d> cloud_W, const Gripper& gripper,
                  int number, const PlanStirOptions& options) {
  CheckSettings("PlanStirOptions", options);
  constexpr double kHeap_m = 0.3;  // a heap above the rim is no higher
  const std::vector<Vector3d> points_W =
      ThinnedCloud(cloud_W, bin, options.voxel_m, options.bin_band_m, kHeap_m);
  const Vector2d room = 0.5 * bin.inner_size_m.head<2>();
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
  const double tips_m = std::max(options.floor_m, Surface_m(points_W) - options.depth_m);
  const Vector2d half = HalfSize(gripper, bin.inner_size_m.z() - tips_m);
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
  const Vector2d beside = BestOffset_m(points_W, direction, half.x(), max_m) * left;
  const Vector2d from = beside - share * way, to = beside + share * way;
  double above_m = bin.inner_size_m.z();
  for (const Vector3d& p_W : points_W) above_m = std::max(above_m, p_W.z());
  return {MakePose(R_WG, {from.x(), from.y(), tips_m}), MakePose(R_WG, {to.x(), to.y(), tips_m}),
          above_m - tips_m + gripper.clearance_m};
}

}  // namespace pickbed::grasp
