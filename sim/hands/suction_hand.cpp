#include "sim/hands/suction_hand.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scenes/geometry/mesh_query.h"
#include "scenes/objects/contact.h"
#include "sim/hands/hand_contacts.h"
#include "sim/hands/suction_seal.h"
#include "sim/physics/bullet_types.h"

namespace pickbed::sim {
namespace {

constexpr double kMoved = 1e-9;  // relative tolerance for equal poses

class CupHand : public Hand, public AttachedHand {
 public:
  CupHand(PhysicsWorld& physics, const CupSpec& spec, const Pose& X_WG);
  ~CupHand() override;

  void MoveTo(const Pose& X_WG) override { target_WG_ = X_WG; }
  void HoldOpening(double) override;
  void Close() override { vacuum_on_ = true; }
  bool HoldsOnContact() const override { return true; }
  double SearchTravel_m() const override { return spec_.bellows_travel_m - spec_.press_m; }
  double opening_m() const override { return spec_.bellows_travel_m - compression_m_; }
  Pose X_WG() const override { return X_WG_; }
  std::array<double, 2> ContactForces_n() const override { return forces_n_; }
  bool Holds() const override { return joint_ != nullptr; }
  HandLoad Load() const override;
  double yielded_m() const override { return 0; }

  void AfterStep(std::vector<PadFriction> frictions) override;
  std::vector<int> TouchedInstances() const override { return touched_; }
  std::vector<const btRigidBody*> Pads() const override { return {}; }
  void LetGoOf(int index) override;

 private:
  struct Facing {
    int index = -1;
    CupSeal seal;
  };
  void Drive();
  Facing FindFacing();
  bool Reaches(const InstanceBody& instance) const;
  bool BlockedByOthers(const InstanceBody& instance) const;
  const MeshQuery& MeshOf(const ObjectModel& model);
  void TakeHold(int index);
  void Release();
  void PressBellows();
  LipLoad ReadLoad() const;
  void JudgeJoint();
  void ReadContacts();

  const PhysicsWorld& physics_;
  btDiscreteDynamicsWorld& world_;
  const CupSpec spec_;
  const double step_s_;
  Pose X_WG_;
  Pose target_WG_;
  std::vector<std::unique_ptr<btBoxShape>> boxes_;
  std::unique_ptr<btCompoundShape> shape_;
  std::unique_ptr<btRigidBody> body_;  // its frame is G
  std::map<const ObjectModel*, MeshQuery> meshes_;
  bool vacuum_on_ = false;
  bool is_lost_ = false;  // the vacuum was on and lost the instance
  double compression_m_ = 0;
  Facing facing_;  // the instance on the lip
  double held_friction_ = 0;
  int state_before_ = ACTIVE_TAG;  // Bullet's activation state of the held instance before
  Pose X_WG_sealed_;
  bool has_moved_ = false;  // since the hold began
  std::unique_ptr<btGeneric6DofSpring2Constraint> joint_;
  btJointFeedback feedback_;
  LipLoad load_;  // of the last step
  LipLoad mean_load_;
  std::array<double, 2> forces_n_{0, 0};
  std::vector<int> touched_;
};

CupHand::CupHand(PhysicsWorld& physics, const CupSpec& spec, const Pose& X_WG)
    : physics_(physics),
      world_(physics.bullet()),
      spec_(spec),
      step_s_(physics.step_s()),
      X_WG_(X_WG),
      target_WG_(X_WG) {
  shape_ = std::make_unique<btCompoundShape>();
  for (const AxisAlignedBox& box : CupBoxes(spec)) {
    boxes_.push_back(std::make_unique<btBoxShape>(ToBullet(box.half_size)));
    shape_->addChildShape(ToBullet(Translation(box.center)), boxes_.back().get());
  }
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape_.get());
  info.m_startWorldTransform = ToBullet(X_WG);
  body_ = std::make_unique<btRigidBody>(info);
  body_->setActivationState(DISABLE_DEACTIVATION);
  body_->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  world_.addRigidBody(body_.get(), kGuidedHandGroup, kStaticGroup | kInstanceGroup);
  world_.setInternalTickCallback(
      [](btDynamicsWorld* w, btScalar) { static_cast<CupHand*>(w->getWorldUserInfo())->Drive(); },
      this, true);
}

CupHand::~CupHand() {
  world_.setInternalTickCallback(nullptr, nullptr, true);
  Release();
  world_.removeRigidBody(body_.get());
}

void CupHand::HoldOpening(double) {
  vacuum_on_ = false;
  is_lost_ = false;
  Release();
}

// Gives the body the velocity that takes it to its target, like a jaw's palm; see jaw_hand.cpp.
void CupHand::Drive() {
  btVector3 linear, angular;
  btTransformUtil::calculateVelocity(body_->getWorldTransform(), ToBullet(target_WG_), step_s_,
                                     linear, angular);
  body_->setLinearVelocity(linear);
  body_->setAngularVelocity(angular);
  if (joint_ == nullptr) PressBellows();
}

// The unsealed bellows is a spring along z of G. The force is computed implicitly, so that light
// objects do not vibrate.
void CupHand::PressBellows() {
  if (facing_.index < 0 || facing_.seal.compression_m <= 0) return;
  btRigidBody* body = physics_.body(facing_.index).body;
  if (body == nullptr || body->isStaticObject()) return;
  const double give = spec_.bellows_npm * step_s_ * step_s_ * body->getInvMass();
  const double force_n = spec_.bellows_npm * facing_.seal.compression_m / (1 + give);
  const Eigen::Vector2d& at = facing_.seal.press_center_m;
  const btVector3 place = ToBullet(Eigen::Vector3d(X_WG_ * Eigen::Vector3d(at.x(), at.y(), 0)));
  const btVector3 force = ToBullet(Eigen::Vector3d(force_n * X_WG_.linear().col(2)));
  body->activate(true);
  body->applyForce(force, place - body->getCenterOfMassPosition());
}

void CupHand::AfterStep(std::vector<PadFriction>) {
  X_WG_ = target_WG_;
  const btTransform X_W = ToBullet(X_WG_);
  body_->setWorldTransform(X_W);
  body_->setInterpolationWorldTransform(X_W);
  if (joint_ != nullptr) {
    JudgeJoint();
  } else {
    facing_ = FindFacing();
    compression_m_ = facing_.index < 0 ? 0 : facing_.seal.compression_m;
    if (vacuum_on_ && !is_lost_ && facing_.index >= 0 && facing_.seal.sealed() &&
        !BlockedByOthers(physics_.body(facing_.index))) {
      TakeHold(facing_.index);
    }
  }
  ReadContacts();
}

bool CupHand::Reaches(const InstanceBody& instance) const {
  if (instance.body == nullptr || instance.body->isStaticObject()) return false;
  const Eigen::Vector3d from_lip =
      X_WG_.inverse() * FromBullet(instance.body->getCenterOfMassPosition());
  const double reach_m = std::hypot(spec_.radius_m, spec_.bellows_travel_m);
  return from_lip.norm() < instance.model->diameter_m + reach_m;
}

const MeshQuery& CupHand::MeshOf(const ObjectModel& model) {
  return meshes_.try_emplace(&model, model.mesh_O).first->second;
}

// Returns the instance that is under the largest share of the rim.
CupHand::Facing CupHand::FindFacing() {
  Facing best;
  for (int i = 0; i < physics_.instance_count(); ++i) {
    const InstanceBody instance = physics_.body(i);
    if (!Reaches(instance)) continue;
    const Pose X_WO = FromBullet(instance.body->getWorldTransform()) * instance.X_BO;
    const CupSeal seal = TestSeal(MeshOf(*instance.model), X_WO.inverse() * X_WG_, spec_);
    if (seal.touching > (best.index < 0 ? 0 : best.seal.touching)) best = {i, seal};
  }
  return best;
}

// Returns whether another instance, the floor or a wall is under the lip.
bool CupHand::BlockedByOthers(const InstanceBody& instance) const {
  constexpr int kRays = 16;
  for (int i = 0; i < kRays; ++i) {
    const double angle = 2 * SIMD_PI * i / kRays;
    const Eigen::Vector3d rim =
        spec_.radius_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector3d behind(0, 0, -spec_.bellows_travel_m);
    const btVector3 from = ToBullet(Eigen::Vector3d(X_WG_ * Eigen::Vector3d(rim + behind)));
    const btVector3 to = ToBullet(Eigen::Vector3d(X_WG_ * rim));
    btCollisionWorld::ClosestRayResultCallback nearest(from, to);
    nearest.m_collisionFilterGroup = kInstanceGroup;
    nearest.m_collisionFilterMask = kStaticGroup | kInstanceGroup;
    world_.rayTest(from, to, nearest);
    if (nearest.hasHit() && nearest.m_collisionObject != instance.body) return true;
  }
  return false;
}

void CupHand::TakeHold(int index) {
  const InstanceBody instance = physics_.body(index);
  const btTransform X_BG = instance.body->getWorldTransform().inverse() * ToBullet(X_WG_);
  joint_ = std::make_unique<btGeneric6DofSpring2Constraint>(*body_, *instance.body,
                                                            btTransform::getIdentity(), X_BG);
  joint_->setLinearLowerLimit({0, 0, 0});
  joint_->setLinearUpperLimit({0, 0, 0});
  joint_->setAngularLowerLimit({0, 0, 0});
  joint_->setAngularUpperLimit({0, 0, 0});
  joint_->setJointFeedback(&feedback_);
  feedback_ = {};
  load_ = mean_load_ = {};
  X_WG_sealed_ = X_WG_;
  has_moved_ = false;
  held_friction_ = PairFriction(instance.friction, spec_.friction);
  // A sleeping instance would not follow, because the hand's motion does not wake bodies.
  state_before_ = instance.body->isActive() ? instance.body->getActivationState() : ACTIVE_TAG;
  instance.body->forceActivationState(DISABLE_DEACTIVATION);
  world_.addConstraint(joint_.get(), true);
}

void CupHand::Release() {
  if (joint_ == nullptr) return;
  world_.removeConstraint(joint_.get());
  joint_->getRigidBodyB().forceActivationState(state_before_);
  joint_->getRigidBodyB().setDeactivationTime(0);
  joint_.reset();
  facing_ = {};
  compression_m_ = 0;
}

void CupHand::LetGoOf(int index) {
  if (facing_.index != index) return;
  is_lost_ = joint_ != nullptr;
  Release();
  facing_ = {};
}

// Bullet reports force and torque on the instance about its center of mass.
LipLoad CupHand::ReadLoad() const {
  const btRigidBody& instance = joint_->getRigidBodyB();
  const Eigen::Matrix3d R_GW = X_WG_.linear().transpose();
  const Eigen::Vector3d on_instance_n = FromBullet(feedback_.m_appliedForceBodyB);
  const Eigen::Vector3d about_com_nm = FromBullet(feedback_.m_appliedTorqueBodyB) / kUnitsPerMeter;
  const Eigen::Vector3d from_lip_m =
      FromBullet(instance.getCenterOfMassPosition()) - X_WG_.translation();
  LipLoad load;
  load.force_n = -(R_GW * on_instance_n);
  load.torque_nm = -(R_GW * (about_com_nm + from_lip_m.cross(on_instance_n)));
  return load;
}

// While the hand does not move, an instance that rests on something puts no load on it. Joint and
// floor share the weight arbitrarily in the solver, which prefers the joint. So the lip has no load
// until the hand moves.
void CupHand::JudgeJoint() {
  has_moved_ = has_moved_ || !X_WG_.isApprox(X_WG_sealed_, kMoved);
  if (!has_moved_) return;
  load_ = ReadLoad();
  const double share = std::min(1.0, step_s_ / spec_.break_after_s);
  mean_load_.force_n += share * (load_.force_n - mean_load_.force_n);
  mean_load_.torque_nm += share * (load_.torque_nm - mean_load_.torque_nm);
  if (ShareOfLimit(spec_, held_friction_, mean_load_) < 1) return;
  is_lost_ = true;
  Release();
}

void CupHand::ReadContacts() {
  touched_.clear();
  const bool presses = facing_.index >= 0 && facing_.seal.compression_m > 0;
  forces_n_ = {0, 0};
  if (joint_ != nullptr) {
    forces_n_[0] = std::max(0.0, spec_.vacuum_n - load_.force_n.z());
  } else if (presses) {
    forces_n_[0] = spec_.bellows_npm * facing_.seal.compression_m;
  }
  if (forces_n_[0] > kTouch_n) touched_.push_back(facing_.index);
  for (const BodyContacts& contacts : ContactsOf(*body_, world_)) {
    const int index = contacts.other->getUserIndex();
    const double force_n = NormalForce_n(*contacts.manifold, step_s_);
    forces_n_[1] += force_n;
    if (index >= 0 && force_n > kTouch_n) touched_.push_back(index);
  }
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
}

// Adds the load through the lip and the contact forces on stem and palm.
HandLoad CupHand::Load() const {
  HandLoad load;
  load.stiff_n = forces_n_[1];
  if (joint_ != nullptr) {
    load.force_n = load_.force_n;
    load.torque_nm = load_.torque_nm;
  } else if (facing_.index >= 0) {
    const Eigen::Vector2d& at = facing_.seal.press_center_m;
    load.force_n.z() = -forces_n_[0];
    load.torque_nm = Eigen::Vector3d(at.x(), at.y(), 0).cross(load.force_n);
  }
  for (const BodyContacts& contacts : ContactsOf(*body_, world_)) {
    if (contacts.other->getUserIndex() < 0) continue;
    const bool hand_is_first = contacts.manifold->getBody0() == body_.get();
    AddContactForces(*contacts.manifold, hand_is_first, X_WG_, step_s_, load);
  }
  return load;
}

}  // namespace

Hand& AddSuctionHand(PhysicsWorld& world, const CupSpec& spec, const Pose& X_WG) {
  auto hand = std::make_unique<CupHand>(world, spec, X_WG);
  Hand& added = *hand;
  world.Attach(std::move(hand));
  return added;
}

std::vector<AxisAlignedBox> CupBoxes(const CupSpec& spec) {
  const Eigen::Vector3d half_stem(spec.stem_radius_m, spec.stem_radius_m, 0.5 * spec.stem_length_m);
  const double stem_z = -spec.bellows_travel_m - half_stem.z();
  const double palm_z = -spec.bellows_travel_m - spec.stem_length_m - 0.5 * spec.palm_size_m.z();
  return {{{0, 0, stem_z}, half_stem}, {{0, 0, palm_z}, 0.5 * spec.palm_size_m}};
}

double RingRadius_m(const CupSpec& spec) {
  return std::min(spec.radius_m, spec.moment_limit_nm / spec.vacuum_n);
}

double ShareOfLimit(const CupSpec& spec, double pair_friction, const LipLoad& load) {
  const double pull_n = std::max(load.force_n.z(), -spec.vacuum_n);
  const double radius_m = RingRadius_m(spec);
  const double bend_nm = load.torque_nm.head<2>().norm();
  // The ring's force is vacuum_n - pull_n. It carries bending up to this force times the radius.
  const double peel = (pull_n + bend_nm / radius_m) / spec.vacuum_n;
  const double grip_n = pair_friction * (spec.vacuum_n - pull_n);
  if (peel >= 1 || grip_n <= 0) return std::max(1.0, peel);
  const double shear = load.force_n.head<2>().norm() / grip_n;
  const double twist = load.torque_nm.z() / (grip_n * radius_m);
  return std::max(peel, std::hypot(shear, twist));
}

}  // namespace pickbed::sim
