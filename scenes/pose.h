#pragma once

// Rigid transforms. X_AB is the pose of frame B in frame A: p_A = X_AB * p_B.
//
// Frames: W world (z up, origin in the middle of the bin's floor), C camera (x right, y down,
// z forward; pixel (0,0) is the centre of the first pixel), O object, G gripper (z approach,
// x closing). Lengths in metres, angles in radians.

#include <Eigen/Geometry>

namespace pickbed {

using Pose = Eigen::Isometry3d;

Pose MakePose(const Eigen::Matrix3d& R_AB, const Eigen::Vector3d& p_AB);
Pose Translation(const Eigen::Vector3d& p_AB);

// Angle of the rotation between two orientations, in [0, pi].
double RotationAngleRad(const Eigen::Matrix3d& R_AB, const Eigen::Matrix3d& R_AC);

// Camera at eye_W that looks at target_W, image y as near to -up_W as it can be. Throws InputError
// when eye and target coincide or the view is parallel to up_W.
Pose LookAt(const Eigen::Vector3d& eye_W, const Eigen::Vector3d& target_W,
            const Eigen::Vector3d& up_W);

// Nearest proper rotation (SVD), to stop drift in long products.
Eigen::Matrix3d Orthonormalized(const Eigen::Matrix3d& matrix);

}  // namespace pickbed
