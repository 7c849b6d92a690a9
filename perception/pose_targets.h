#pragma once

// The pose of a part in the frame of a patch as a network regresses it: the rotation R_PO and the
// part's centre of mass as seen from the patch's middle, in sides of the patch. No symmetry moves
// the centre of mass, so that only the rotation has several values that are equally right.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <span>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

// What a network gives for one patch and part, in this order: how likely the patch shows the part
// (shares of all parts add up to 1), R_PO row by row, the centre of mass.
inline constexpr int kPoseValues = 1 + 9 + 3;

// Gives count x parts x kPoseValues values for count patches.
using RegressPoses = std::function<std::vector<float>(std::span<const int8_t> patches)>;

class PoseTargets {
 public:
  PoseTargets(const ObjectModel& model, double side_m);

  int variants() const { return static_cast<int>(symmetries_O_.size()); }
  // Quaternions w x y z of R_PO under each symmetry, continuous ones in steps; identity first.
  void AppendRotations(const Pose& X_PO, std::vector<float>& quaternions) const;
  Eigen::Vector3f Middle(const Pose& X_PO) const;

  // The pose of which a network says this: kPoseValues values.
  Pose PoseOf(std::span<const float> values) const;

 private:
  std::vector<Eigen::Quaterniond> symmetries_O_;
  Eigen::Vector3d com_O_;
  double side_m_ = 1;
};

}  // namespace pickbed
