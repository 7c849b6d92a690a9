#include "perception/features/pose_targets.h"

namespace pickbed::perception {
namespace {

// Samples of a continuous symmetry. ICP corrects the remaining error of half a step, 7.5 degrees.
constexpr int kSteps = 24;

}  // namespace

PoseTargets::PoseTargets(const ObjectModel& model, double side_m)
    : com_O_(model.mass.com_O), side_m_(side_m) {
  for (const Pose& S_O : SymmetryTransforms(model.symmetries_O, kSteps)) {
    symmetries_O_.emplace_back(S_O.linear());
  }
}

void PoseTargets::AppendRotations(const Pose& X_PO, std::vector<float>& quaternions) const {
  const Eigen::Quaterniond R_PO(X_PO.linear());
  for (const Eigen::Quaterniond& S_O : symmetries_O_) {
    const Eigen::Quaternionf q = (R_PO * S_O).cast<float>();
    quaternions.insert(quaternions.end(), {q.w(), q.x(), q.y(), q.z()});
  }
}

Eigen::Vector3f PoseTargets::Center(const Pose& X_PO) const {
  return (X_PO * com_O_ / side_m_).cast<float>();
}

Pose PoseTargets::PoseOf(std::span<const float> values) const {
  using RowMajor = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  const Eigen::Matrix3d R_PO = Eigen::Map<const RowMajor>(values.data() + 1).cast<double>();
  const Eigen::Vector3d center =
      Eigen::Map<const Eigen::Vector3f>(values.data() + 10).cast<double>();
  return MakePose(R_PO, side_m_ * center - R_PO * com_O_);
}

}  // namespace pickbed::perception
