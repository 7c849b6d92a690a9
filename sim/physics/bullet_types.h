#pragma once

// Units, collision groups and conversions for the files that use Bullet. This header only declares
// Bullet's types.
//
// The unit of length in Bullet is the decimetre. The tolerances of its narrow phase are absolute
// and suit bodies of about one unit. With metres it was 4 to 10 times slower on objects of a few
// centimetres, and in single precision it missed overlaps of 5 mm. Masses are in kg and times in s.
// So velocities, accelerations and forces carry the factor once, torques and inertias twice.

#include "scenes/geometry/pose.h"
#include "sim/layer.h"

class btMatrix3x3;
class btTransform;
class btVector3;

namespace pickbed::sim {

inline constexpr double kUnitsPerMeter = 10;

// Smallest cosine between a contact's normal and a pad's (25 degrees). Contacts at the finger's tip
// and edges are outside it and are treated like contacts of other bodies.
inline constexpr double kPadNormal = 0.9;

// Collision groups. Static bodies have explicit ones, because bodies of a hand would pass through
// Bullet's default group.
enum CollisionGroup : int {
  kStaticGroup = 1 << 0,  // bin, boxes and static instances
  kFunnelGroup = 1 << 1,
  kInstanceGroup = 1 << 2,
  kDrivenHandGroup = 1 << 3,  // bodies of a hand that motors move
  kGuidedHandGroup = 1 << 4,  // bodies of a hand that are moved kinematically
};

btVector3 ToBullet(const Eigen::Vector3d& metric);  // multiplies by kUnitsPerMeter
// Converts a pose in metres to Bullet's units.
btTransform ToBullet(const Pose& X_AB);
// Converts a position or displacement in Bullet's units to metres.
Eigen::Vector3d FromBullet(const btVector3& scaled);
// Converts a pose in Bullet's units to metres.
Pose FromBullet(const btTransform& X_AB);

}  // namespace pickbed::sim
