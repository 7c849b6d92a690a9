#include "scenes/geometry/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/base/error.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::scenes {
namespace {

bool AreParallel(const ContinuousSymmetry& a, const ContinuousSymmetry& b) {
  constexpr double kParallel = 1e-6;
  return a.axis_O.cross(b.axis_O).norm() < kParallel;
}

// Returns whether the two axes are the same line.
bool SameLine(const ContinuousSymmetry& a, const ContinuousSymmetry& b, double tolerance_m) {
  return AreParallel(a, b) && (b.offset_O - a.offset_O).cross(a.axis_O).norm() <= tolerance_m;
}

// Returns the point where two axes meet. Throws InputError if they are parallel or do not meet.
Eigen::Vector3d MeetingPoint(const ContinuousSymmetry& a, const ContinuousSymmetry& b,
                             double tolerance_m) {
  const Eigen::Vector3d normal = a.axis_O.cross(b.axis_O);
  const Eigen::Vector3d between = b.offset_O - a.offset_O;
  const double squared = normal.squaredNorm();
  CheckInput(squared > 1e-12 && std::abs(between.dot(normal)) <= tolerance_m * std::sqrt(squared),
             "two continuous symmetry axes do not meet in a point; no object can have both, so "
             "remove one");
  return a.offset_O + between.cross(b.axis_O).dot(normal) / squared * a.axis_O;
}

std::vector<Pose> TurnsAboutAxis(const ContinuousSymmetry& axis, int steps) {
  std::vector<Pose> turns;
  turns.reserve(steps);
  for (int i = 0; i < steps; ++i) {
    turns.push_back(TurnAbout(axis, 2 * std::numbers::pi * i / steps));
  }
  return turns;
}

// Two axes through a point generate every rotation about it. The result is a grid of Euler angles
// about the axis, a perpendicular and the axis again. It has about 32 * steps elements, because
// `steps` cubed would be too many to use.
std::vector<Pose> AllRotations(const Eigen::Vector3d& axis_O, const Eigen::Vector3d& center_O,
                               int steps) {
  const int turns = std::max(4, 2 * static_cast<int>(std::lround(std::cbrt(8.0 * steps))));
  const double step_rad = 2 * std::numbers::pi / turns;
  const ContinuousSymmetry along{axis_O, center_O}, across{axis_O.unitOrthogonal(), center_O};
  std::vector<Pose> rotations;
  for (int tilt = 0; tilt <= turns / 2; ++tilt) {
    const bool pole = tilt == 0 || tilt == turns / 2;  // here both outer rotations are redundant
    const Pose X_tilt = TurnAbout(across, tilt * step_rad);
    for (int i = 0; i < turns; ++i) {
      const Pose X_first = TurnAbout(along, i * step_rad) * X_tilt;
      for (int j = 0; j < (pole ? 1 : turns); ++j) {
        rotations.push_back(X_first * TurnAbout(along, j * step_rad));
      }
    }
  }
  return rotations;
}

std::vector<Pose> ContinuousTransforms(const std::vector<ContinuousSymmetry>& axes, int steps) {
  constexpr double kSameLine_m = 1e-5;  // a tenth of the accuracy to which any object is known
  if (axes.empty()) return {Pose::Identity()};
  for (const ContinuousSymmetry& other : axes) {
    if (SameLine(axes.front(), other, kSameLine_m)) continue;
    return AllRotations(axes.front().axis_O, MeetingPoint(axes.front(), other, kSameLine_m), steps);
  }
  return TurnsAboutAxis(axes.front(), steps);
}

}  // namespace

Pose TurnAbout(const ContinuousSymmetry& axis, double angle_rad) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle_rad, axis.axis_O).toRotationMatrix();
  return MakePose(R, axis.offset_O - R * axis.offset_O);
}

Eigen::Vector3d PointOnAxis(const Pose& X) {
  const Eigen::Matrix3d moved = Eigen::Matrix3d::Identity() - X.linear();
  return MinimumNormSolution(moved, X.translation());
}

const ContinuousSymmetry* SecondAxis(const SymmetrySet& symmetries) {
  for (const ContinuousSymmetry& axis : symmetries.continuous_O) {
    if (!AreParallel(symmetries.continuous_O.front(), axis)) return &axis;
  }
  return nullptr;
}

std::vector<Pose> SymmetryTransforms(const SymmetrySet& symmetries, int steps) {
  if (steps < 1) throw std::invalid_argument("SymmetryTransforms needs at least one step");
  std::vector<Pose> transforms = ContinuousTransforms(symmetries.continuous_O, steps);
  const size_t turns = transforms.size();
  transforms.reserve(turns * (1 + symmetries.discrete_O.size()));
  for (const Pose& discrete : symmetries.discrete_O) {
    for (size_t i = 0; i < turns; ++i) transforms.push_back(discrete * transforms[i]);
  }
  return transforms;
}

}  // namespace pickbed::scenes
