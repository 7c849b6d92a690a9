#include "perception/model/ambiguous_poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/geometry/decompositions.h"

namespace pickbed::perception {
namespace {

constexpr int kSamples = 300;           // compared surface points
constexpr float kFarDiameters = 0.15f;  // larger distances are clamped to this value

// The 24 rotations that map the axes onto themselves.
std::vector<Eigen::Matrix3d> CubeRotations() {
  std::vector<Eigen::Matrix3d> rotations;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x / 2 == y / 2) continue;
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      R(x / 2, 0) = x % 2 ? -1 : 1;
      R(y / 2, 1) = y % 2 ? -1 : 1;
      R.col(2) = R.col(0).cross(R.col(1));
      rotations.push_back(R);
    }
  }
  return rotations;
}

// Returns the principal axes of the surface as columns.
Eigen::Matrix3d PrincipalAxes(const ModelPoints& points) {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& p : points.points_O) mean += p;
  mean /= static_cast<float>(points.points_O.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& p : points.points_O) {
    const Eigen::Vector3d q = (p - mean).cast<double>();
    covariance += q * q.transpose();
  }
  Eigen::Matrix3d axes = EigenOfSymmetric3(covariance).vectors;
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return axes;
}

// Rotations by multiples of 15 degrees about each axis.
std::vector<Eigen::Matrix3d> AxisRotations() {
  constexpr int kSteps = 24;
  std::vector<Eigen::Matrix3d> rotations;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 1; i < kSteps; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSteps;
      rotations.push_back(Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix());
    }
  }
  return rotations;
}

struct Gap {
  double mean_m = 0;
  Eigen::Vector3d way_m = Eigen::Vector3d::Zero();  // mean vector from the points to the surface
};

// Gap between the surface moved by S_O and the original surface.
Gap GapOf(const ModelPoints& points, const Pose& S_O) {
  const Eigen::Isometry3f S = S_O.cast<float>();
  const int count = std::min<int>(kSamples, static_cast<int>(points.points_O.size()));
  const float far_m = kFarDiameters * points.diameter_m;
  const float step_m = points.distance.cell_m;
  Gap gap;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f p = S * points.points_O[i];
    const float d = points.distance.At(p);
    gap.mean_m += std::min(far_m, d) / count;
    if (d >= far_m) continue;
    Eigen::Vector3f slope;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3f h = step_m * Eigen::Vector3f::Unit(axis);
      slope[axis] = points.distance.At(p + h) - points.distance.At(p - h);
    }
    const float length = slope.norm();
    if (length > 0) gap.way_m -= (d / length * slope).cast<double>() / count;
  }
  return gap;
}

struct Turn {
  Pose S_O;
  double gap_m = 0;
};

// Rotates about the center, then translates to the best fit.
Turn Settled(const ModelPoints& points, const Eigen::Matrix3d& R) {
  constexpr int kSteps = 15;
  const Pose to_center = Translation(points.center_O.cast<double>());
  Pose S_O = to_center * MakePose(R, Eigen::Vector3d::Zero()) * to_center.inverse();
  Gap gap = GapOf(points, S_O);
  Turn best{S_O, gap.mean_m};
  for (int step = 0; step < kSteps; ++step) {
    // Points that can slide along a wall contribute nothing in that direction. The mean is
    // therefore too short, and a longer step is safe.
    constexpr double kLonger = 2;
    S_O.translation() += kLonger * gap.way_m;
    gap = GapOf(points, S_O);
    if (gap.mean_m < best.gap_m) best = {S_O, gap.mean_m};
  }
  return best;
}

}  // namespace

std::vector<Pose> AmbiguousPoses(const ObjectModel& model, const ModelPoints& points,
                                 const PoseDistance& distance,
                                 const AmbiguousPoseOptions& options) {
  std::vector<Eigen::Matrix3d> rotations = CubeRotations();
  for (const Eigen::Matrix3d& R : AxisRotations()) rotations.push_back(R);
  const double max_gap_m = options.max_gap_diameters * model.diameter_m;
  std::vector<Turn> turns;
  // The shape may be aligned with the mesh axes or with the principal axes: both are tried.
  const Eigen::Matrix3d mesh_axes = Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& axes : {PrincipalAxes(points), mesh_axes}) {
    for (const Eigen::Matrix3d& R : rotations) {
      const Turn turn = Settled(points, axes * R * axes.transpose());
      if (turn.gap_m <= max_gap_m) turns.push_back(turn);
    }
  }
  std::stable_sort(turns.begin(), turns.end(),
                   [](const Turn& a, const Turn& b) { return a.gap_m < b.gap_m; });
  std::vector<Pose> kept;
  for (const Turn& turn : turns) {
    if (static_cast<int>(kept.size()) >= options.max_poses) break;
    const auto is_near = [&](const Pose& other) {
      return distance(turn.S_O, other) < options.min_move_diameters;
    };
    if (is_near(Pose::Identity()) || std::any_of(kept.begin(), kept.end(), is_near)) continue;
    kept.push_back(turn.S_O);
  }
  return kept;
}

}  // namespace pickbed::perception
