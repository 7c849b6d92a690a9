#include "sim/physics/bullet_types.h"

#include <btBulletDynamicsCommon.h>

namespace pickbed::sim {

btVector3 ToBullet(const Eigen::Vector3d& metric) {
  return {metric.x() * kUnitsPerMeter, metric.y() * kUnitsPerMeter, metric.z() * kUnitsPerMeter};
}

btTransform ToBullet(const Pose& X_AB) {
  const Eigen::Matrix3d& R = X_AB.linear();
  const btMatrix3x3 basis(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                          R(2, 2));
  return btTransform(basis, ToBullet(Eigen::Vector3d(X_AB.translation())));
}

Eigen::Vector3d FromBullet(const btVector3& scaled) {
  return Eigen::Vector3d(scaled.x(), scaled.y(), scaled.z()) / kUnitsPerMeter;
}

Pose FromBullet(const btTransform& X_AB) {
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) pose.linear()(row, col) = X_AB.getBasis()[row][col];
  }
  pose.translation() = FromBullet(X_AB.getOrigin());
  return pose;
}

}  // namespace pickbed::sim
