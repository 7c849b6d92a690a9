#pragma once

// Regression targets of a network for the object pose in the patch frame P: the rotation R_PO, and
// the center of mass in P in units of the patch side. No symmetry moves the center of mass, so only
// the rotation has several equally right values.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <span>
#include <vector>

#include "perception/layer.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

// Network outputs for one patch and object, in this order: probability that the patch shows the
// object (sums to 1 over all objects), R_PO row by row, center of mass.
inline constexpr int kPoseValues = 1 + 9 + 3;

// Maps count patches to count x object_count x kPoseValues values.
using RegressPoses = std::function<std::vector<float>(std::span<const int8_t> patches)>;

// Converts between object poses in P and regression targets for patches with side side_m.
class PoseTargets {
 public:
  PoseTargets(const ObjectModel& model, double side_m);

  // Number of equally right rotations.
  int variants() const { return static_cast<int>(symmetries_O_.size()); }
  // Appends the quaternion (w, x, y, z) of R_PO under each symmetry, identity first. Continuous
  // symmetries are sampled.
  void AppendRotations(const Pose& X_PO, std::vector<float>& quaternions) const;
  // Returns the center of mass in P, in units of the patch side.
  Eigen::Vector3f Center(const Pose& X_PO) const;

  // Returns X_PO from the kPoseValues outputs of a network.
  Pose PoseOf(std::span<const float> values) const;

 private:
  std::vector<Eigen::Quaterniond> symmetries_O_;
  Eigen::Vector3d com_O_;
  double side_m_ = 1;
};

}  // namespace pickbed::perception
