#pragma once

// Private to sim's physics: units, collision groups and the hand's side of the world, shared by
// physics_world.cpp and hand_joints.cpp. Bullet's types are only named here, never included.
//
// Inside Bullet the unit of length is the decimetre. Its narrow phase has absolute tolerances that
// suit bodies of about one unit: in metres it was 4 to 10 times slower on parts of a few
// centimetres, and in single precision hid overlaps of 5 mm. Masses stay kg and times s, so
// velocities, accelerations and forces carry the factor once, torques and inertias twice.

#include <memory>
#include <vector>

#include "scenes/pose.h"
#include "sim/hand_joints.h"

class btDiscreteDynamicsWorld;
class btMatrix3x3;
class btTransform;
class btVector3;

namespace pickbed {

inline constexpr double kUnitsPerMeter = 10;

// Static bodies get explicit groups, since Bullet's default one would let fingers through them.
enum CollisionGroup : int {
  kStaticGroup = 1 << 0,  // bin, boxes and parts that may not move
  kFunnelGroup = 1 << 1,
  kPartGroup = 1 << 2,
  kFingerGroup = 1 << 3,
  kPalmGroup = 1 << 4,
};

btVector3 ToBullet(const Eigen::Vector3d& metric);  // times kUnitsPerMeter
btTransform ToBullet(const Pose& X_AB);
Eigen::Vector3d FromBullet(const btVector3& scaled);
Pose FromBullet(const btTransform& X_AB);

// What the world needs of a hand beyond its public face. Part bodies carry their index as user
// index; all other bodies keep Bullet's -1.
class BulletHand : public Hand {
 public:
  virtual void AfterStep() = 0;
  virtual std::vector<int> TouchedParts() const = 0;
};

// The hand adds itself to `world`, which must outlive it, and takes itself out when destroyed.
std::unique_ptr<BulletHand> MakeBulletHand(btDiscreteDynamicsWorld& world, const HandSpec& spec,
                                           const Pose& X_WG, double step_s);

}  // namespace pickbed
