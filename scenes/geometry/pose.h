#pragma once

// Rigid transforms. X_AB is the pose of frame B in frame A: p_A = X_AB * p_B.
//
// Frames (lengths in metres, angles in radians):
//   W world: z up, origin in the center of the bin's floor
//   C camera: x right, y down, z forward; pixel (0,0) is the center of the first pixel
//   O object, as its mesh defines it
//   G gripper: z approach, x closing
//
//     W  z                  C     z (forward)            G ---+---  x (closing)
//        |  y                    /                            |
//        | /                    +---- x (right)               |
//        +---- x                |                             v
//                               y (down)                      z (approach)

#include <Eigen/Geometry>
#include <string>

namespace pickbed::scenes {

using Pose = Eigen::Isometry3d;

// Returns X_AB from its rotation and translation (m).
Pose MakePose(const Eigen::Matrix3d& R_AB, const Eigen::Vector3d& p_AB);
// Returns X_AB from its translation (m), without a rotation.
Pose Translation(const Eigen::Vector3d& p_AB);

// Returns the angle of the rotation between two orientations, in [0, pi].
double RotationAngleRad(const Eigen::Matrix3d& R_AB, const Eigen::Matrix3d& R_AC);

// Returns the pose X_WC of a camera at eye_W that looks at target_W. The image's y axis is as close
// to -up_W as possible. Throws InputError when eye and target coincide or the view is parallel to
// up_W.
Pose LookAt(const Eigen::Vector3d& eye_W, const Eigen::Vector3d& target_W,
            const Eigen::Vector3d& up_W);

// Returns the nearest proper rotation (by SVD). It removes the drift of long products.
Eigen::Matrix3d Orthonormalized(const Eigen::Matrix3d& matrix);

// Largest error of a rotation that another program gives: deviation of R^T R from the identity.
inline constexpr double kMaxRotationError = 1e-3;

// Returns the rotation that another program gives. One that is exact up to rounding is not changed,
// and an error up to kMaxRotationError is corrected. Throws InputError that begins with `name` for
// a larger error, a reflection, or a value that is not finite.
Eigen::Matrix3d ProperRotation(const Eigen::Matrix3d& R, const std::string& name);

}  // namespace pickbed::scenes
