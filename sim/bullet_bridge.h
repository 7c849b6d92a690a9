#pragma once

// Private to sim's physics: units, collision groups and the hand's side of the world, shared by
// physics_world.cpp and hand_joints.cpp. Bullet's types are only named here, never included.
//
// Inside Bullet the unit of length is the decimetre. Its narrow phase has absolute tolerances that
// suit bodies of about one unit: in metres it was 4 to 10 times slower on parts of a few
// centimetres, and in single precision hid overlaps of 5 mm. Masses stay kg and times s, so
// velocities, accelerations and forces carry the factor once, torques and inertias twice.

#include <functional>
#include <memory>
#include <vector>

#include "scenes/object_model.h"
#include "scenes/pose.h"
#include "sim/cup_joint.h"
#include "sim/hand_joints.h"

class btDiscreteDynamicsWorld;
class btMatrix3x3;
class btRigidBody;
class btTransform;
class btVector3;

namespace pickbed {

inline constexpr double kUnitsPerMeter = 10;

// Contacts whose normal is within 25 degrees of a pad's are the pad's; those at the finger's tip
// and edges are like any other body's.
inline constexpr double kPadNormal = 0.9;

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

// Friction of the patch of a pad, on the pad, in W: see sim/patch_friction_impl.h.
struct PadFriction {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_nm = Eigen::Vector3d::Zero();  // about the place
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
};

// What the world needs of a hand beyond its public face. Part bodies carry their index as user
// index; all other bodies keep Bullet's -1.
class BulletHand : public Hand {
 public:
  virtual void AfterStep(std::vector<PadFriction> frictions) = 0;
  virtual std::vector<int> TouchedParts() const = 0;
  // Bodies that lie flat on what they hold.
  virtual std::vector<const btRigidBody*> Pads() const = 0;
  // The part is about to be taken out of the world.
  virtual void LetGoOf(int part) = 0;
};

// A part as a hand sees it.
struct PartInWorld {
  btRigidBody* body = nullptr;         // null once it was taken out
  const ObjectModel* model = nullptr;  // valid as long as the caller of AddPart keeps it
  Pose X_BO = Pose::Identity();        // B: the body's own frame
};

// What a cup asks of the world: how many parts there are, and the one of an index.
struct PartsInWorld {
  std::function<int()> count;
  std::function<PartInWorld(int)> part;
};

// The hand adds itself to `world`, which must outlive it, and takes itself out when destroyed.
std::unique_ptr<BulletHand> MakeBulletHand(btDiscreteDynamicsWorld& world, const HandSpec& spec,
                                           const Pose& X_WG, double step_s);
std::unique_ptr<BulletHand> MakeBulletCup(btDiscreteDynamicsWorld& world, const CupSpec& spec,
                                          const Pose& X_WG, double step_s, PartsInWorld parts);

}  // namespace pickbed
