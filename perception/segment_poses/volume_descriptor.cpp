#include "perception/segment_poses/volume_descriptor.h"

#include <Eigen/Geometry>

namespace pickbed::perception {
namespace {

// Less probable matter does not move the frame. There is much of it behind an occluder.
constexpr float kProbable = 0.3f;

}  // namespace

std::optional<Pose> VolumeFrame(const CompletedVolume& volume) {
  Eigen::Vector3d sum_C = Eigen::Vector3d::Zero();
  double weight = 0;
  for (int z = 0; z < volume.size; ++z) {
    for (int y = 0; y < volume.size; ++y) {
      for (int x = 0; x < volume.size; ++x) {
        const float p = volume.occupancy[volume.Index(x, y, z)];
        if (p < kProbable) continue;
        sum_C += p * volume.Center_C(x, y, z).cast<double>();
        weight += p;
      }
    }
  }
  if (weight <= 0) return std::nullopt;
  const Eigen::Vector3d center_C = sum_C / weight;
  const Eigen::Quaterniond q_CF =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), center_C);
  return MakePose(q_CF.toRotationMatrix(), center_C);
}

void AppendVolumeDescriptor(const CompletedVolume& volume, const Pose& X_CF, double angle_rad,
                            double side_m, std::vector<float>& values) {
  const Eigen::Matrix3d R_CG =
      X_CF.linear() * Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3f step_C = (R_CG * (side_m / kDescriptorCells)).cast<float>();
  const Eigen::Vector3f center_C = X_CF.translation().cast<float>();
  constexpr float kCenter = 0.5f * (kDescriptorCells - 1);
  for (int z = 0; z < kDescriptorCells; ++z) {
    for (int y = 0; y < kDescriptorCells; ++y) {
      for (int x = 0; x < kDescriptorCells; ++x) {
        const Eigen::Vector3f from_center = Eigen::Vector3f(x, y, z).array() - kCenter;
        values.push_back(volume.At(center_C + step_C * from_center));
      }
    }
  }
}

}  // namespace pickbed::perception
