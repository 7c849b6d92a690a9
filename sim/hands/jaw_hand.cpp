#include "sim/hands/jaw_hand.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>

#include "sim/hands/hand_contacts.h"
#include "sim/physics/bullet_types.h"

namespace pickbed::sim {
namespace {

// Contacts of an instance that rocks between the pads come and go. A contact that is lost for
// longer counts as lost.
constexpr double kTouchLasts_s = 0.02;

btVector3 Column(const btRigidBody& body, int axis) {
  return body.getWorldTransform().getBasis().getColumn(axis);
}

// One constraint row that keeps the fingers' displacements along the palm's x opposite, like a rack
// and pinion: x_left + x_right = 0. The palm is kinematic, so its velocity is on the right-hand
// side.
class FingerCoupling : public btTypedConstraint {
 public:
  FingerCoupling(btRigidBody& left, btRigidBody& right, const btRigidBody& palm)
      : btTypedConstraint(MAX_CONSTRAINT_TYPE, left, right), palm_(palm) {}

  void getInfo1(btConstraintInfo1* info) override {
    info->m_numConstraintRows = 1;
    info->nub = 1;
  }

  void getInfo2(btConstraintInfo2* info) override {
    const btVector3 axis = Column(palm_, 0);
    const btVector3 arms = m_rbA.getCenterOfMassPosition() + m_rbB.getCenterOfMassPosition() -
                           2 * palm_.getCenterOfMassPosition();
    for (int i = 0; i < 3; ++i) {
      info->m_J1linearAxis[i] = axis[i];
      info->m_J2linearAxis[i] = axis[i];
      info->m_J1angularAxis[i] = 0;
      info->m_J2angularAxis[i] = 0;
    }
    const double error = arms.dot(axis);
    const double palm_rate =
        2 * palm_.getLinearVelocity().dot(axis) - arms.dot(palm_.getAngularVelocity().cross(axis));
    info->m_constraintError[0] = palm_rate - info->fps * info->erp * error;
    info->m_lowerLimit[0] = -SIMD_INFINITY;
    info->m_upperLimit[0] = SIMD_INFINITY;
  }

  void setParam(int, btScalar, int) override {}
  btScalar getParam(int, int) const override { return 0; }

 private:
  const btRigidBody& palm_;
};

// Stop of a finger along the palm's z, at distance `home` from the palm's center. A force presses
// the finger against it, and a push must exceed this force to move the finger.
class OverloadSlide : public btTypedConstraint {
 public:
  OverloadSlide(btRigidBody& finger, const btRigidBody& palm, btScalar home, btScalar force)
      : btTypedConstraint(MAX_CONSTRAINT_TYPE, finger), palm_(palm), home_(home), force_(force) {}

  // Displacement of the finger from its stop.
  btScalar Displacement() const { return Arm().dot(Column(palm_, 2)) - home_; }

  void getInfo1(btConstraintInfo1* info) override {
    info->m_numConstraintRows = 1;
    info->nub = 1;
  }

  void getInfo2(btConstraintInfo2* info) override {
    const btVector3 axis = Column(palm_, 2);
    for (int i = 0; i < 3; ++i) {
      info->m_J1linearAxis[i] = axis[i];
      info->m_J1angularAxis[i] = 0;
    }
    const double palm_rate =
        palm_.getLinearVelocity().dot(axis) - Arm().dot(palm_.getAngularVelocity().cross(axis));
    info->m_constraintError[0] = palm_rate - info->fps * info->erp * Displacement();
    info->m_lowerLimit[0] = -SIMD_INFINITY;
    info->m_upperLimit[0] = force_ / info->fps;
  }

  void setParam(int, btScalar, int) override {}
  btScalar getParam(int, int) const override { return 0; }

 private:
  btVector3 Arm() const {
    return m_rbA.getCenterOfMassPosition() - palm_.getCenterOfMassPosition();
  }

  const btRigidBody& palm_;
  const btScalar home_;
  const btScalar force_;
};

class JawHand : public Hand, public AttachedHand {
 public:
  JawHand(btDiscreteDynamicsWorld& world, const HandSpec& spec, const Pose& X_WG, double step_s);
  ~JawHand() override;

  void MoveTo(const Pose& X_WG) override { target_WG_ = X_WG; }
  void HoldOpening(double opening_m) override;
  void Close() override;
  double opening_m() const override;
  Pose X_WG() const override { return X_WG_; }
  std::array<double, 2> ContactForces_n() const override { return forces_n_; }
  bool Holds() const override { return std::max(untouched_s_[0], untouched_s_[1]) < kTouchLasts_s; }
  HandLoad Load() const override;
  double yielded_m() const override;

  void AfterStep(std::vector<PadFriction> frictions) override;
  std::vector<int> TouchedInstances() const override { return touched_; }
  std::vector<const btRigidBody*> Pads() const override {
    return {fingers_[0].get(), fingers_[1].get()};
  }
  void LetGoOf(int) override {}

 private:
  std::unique_ptr<btRigidBody> MakeBody(const btCollisionShape& shape, double mass_kg,
                                        const Pose& X_WB) const;
  void AddSlider(int finger);
  void DrivePalm();
  void ReadContacts();

  btDiscreteDynamicsWorld& world_;
  const HandSpec spec_;
  const double step_s_;
  Pose X_GP_;  // P = center of the palm's box
  Pose X_WG_;
  Pose target_WG_;
  std::unique_ptr<btBoxShape> palm_shape_;
  std::unique_ptr<btBoxShape> finger_shape_;
  std::unique_ptr<btRigidBody> palm_;
  std::array<std::unique_ptr<btRigidBody>, 2> fingers_;  // left (-x), right (+x)
  std::array<std::unique_ptr<btGeneric6DofSpring2Constraint>, 2> sliders_;
  std::array<std::unique_ptr<OverloadSlide>, 2> slides_;
  std::unique_ptr<FingerCoupling> coupling_;
  std::array<double, 2> forces_n_{0, 0};
  std::array<double, 2> untouched_s_{kTouchLasts_s, kTouchLasts_s};  // since the last touch
  std::vector<int> touched_;
  std::vector<PadFriction> frictions_;
};

JawHand::JawHand(btDiscreteDynamicsWorld& world, const HandSpec& spec, const Pose& X_WG,
                 double step_s)
    : world_(world), spec_(spec), step_s_(step_s), X_WG_(X_WG), target_WG_(X_WG) {
  const std::vector<AxisAlignedBox> boxes = HandBoxes(spec, spec.stroke_m);
  X_GP_ = Translation(boxes[2].center);
  palm_shape_ = std::make_unique<btBoxShape>(ToBullet(boxes[2].half_size));
  finger_shape_ = std::make_unique<btBoxShape>(ToBullet(boxes[0].half_size));
  palm_ = MakeBody(*palm_shape_, 0, X_WG * X_GP_);
  palm_->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  world_.addRigidBody(palm_.get(), kGuidedHandGroup, kStaticGroup | kInstanceGroup);
  for (int i = 0; i < 2; ++i) {
    fingers_[i] =
        MakeBody(*finger_shape_, spec.finger_mass_kg, X_WG * Translation(boxes[i].center));
    fingers_[i]->setFriction(spec.pad_friction);
    fingers_[i]->setCollisionFlags(btCollisionObject::CF_HAS_FRICTION_ANCHOR);
    // Fingers do not sag, because the friction of a real drive carries them.
    fingers_[i]->setFlags(fingers_[i]->getFlags() | BT_DISABLE_WORLD_GRAVITY);
    world_.addRigidBody(fingers_[i].get(), kDrivenHandGroup, kStaticGroup | kInstanceGroup);
    AddSlider(i);
  }
  coupling_ = std::make_unique<FingerCoupling>(*fingers_[0], *fingers_[1], *palm_);
  world_.addConstraint(coupling_.get(), true);
  HoldOpening(spec.stroke_m);
  world_.setInternalTickCallback(
      [](btDynamicsWorld* w, btScalar) {
        static_cast<JawHand*>(w->getWorldUserInfo())->DrivePalm();
      },
      this, true);
}

JawHand::~JawHand() {
  world_.setInternalTickCallback(nullptr, nullptr, true);
  world_.removeConstraint(coupling_.get());
  for (int i = 0; i < 2; ++i) {
    world_.removeConstraint(slides_[i].get());
    world_.removeConstraint(sliders_[i].get());
    world_.removeRigidBody(fingers_[i].get());
  }
  world_.removeRigidBody(palm_.get());
}

std::unique_ptr<btRigidBody> JawHand::MakeBody(const btCollisionShape& shape, double mass_kg,
                                               const Pose& X_WB) const {
  btVector3 inertia(0, 0, 0);
  if (mass_kg > 0) shape.calculateLocalInertia(mass_kg, inertia);
  btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr,
                                                const_cast<btCollisionShape*>(&shape), inertia);
  info.m_startWorldTransform = ToBullet(X_WB);
  auto body = std::make_unique<btRigidBody>(info);
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

// The slider coordinate is the finger's displacement along x from where the pads meet.
void JawHand::AddSlider(int finger) {
  const double side = finger == 0 ? -1 : 1;
  const AxisAlignedBox closed = HandBoxes(spec_, 0)[finger];
  const Pose X_PS = X_GP_.inverse() * Translation(closed.center);
  sliders_[finger] = std::make_unique<btGeneric6DofSpring2Constraint>(
      *palm_, *fingers_[finger], ToBullet(X_PS), btTransform::getIdentity());
  btGeneric6DofSpring2Constraint& slider = *sliders_[finger];
  const double open = side * 0.5 * spec_.stroke_m * kUnitsPerMeter;
  // Bullet treats a lower limit above the upper one as a free axis.
  slider.setLinearLowerLimit({std::min(0.0, open), 0, 1});
  slider.setLinearUpperLimit({std::max(0.0, open), 0, -1});
  slider.setAngularLowerLimit({0, 0, 0});
  slider.setAngularUpperLimit({0, 0, 0});
  slider.enableMotor(0, true);
  slider.setMaxMotorForce(0, spec_.force_n * kUnitsPerMeter);
  world_.addConstraint(&slider, true);
  slides_[finger] = std::make_unique<OverloadSlide>(*fingers_[finger], *palm_,
                                                    X_PS.translation().z() * kUnitsPerMeter,
                                                    spec_.yield_n * kUnitsPerMeter);
  world_.addConstraint(slides_[finger].get(), true);
}

void JawHand::HoldOpening(double opening_m) {
  const double target = 0.5 * std::clamp(opening_m, 0.0, spec_.stroke_m) * kUnitsPerMeter;
  for (int i = 0; i < 2; ++i) {
    sliders_[i]->setServo(0, true);
    sliders_[i]->setServoTarget(0, i == 0 ? -target : target);
    sliders_[i]->setTargetVelocity(0, spec_.close_speed_mps * kUnitsPerMeter);
  }
}

void JawHand::Close() {
  for (int i = 0; i < 2; ++i) {
    sliders_[i]->setServo(0, false);
    // Bullet measures a linear motor's velocity from finger to palm; positive moves towards -x.
    const double toward_minus_x = i == 0 ? -1 : 1;
    sliders_[i]->setTargetVelocity(0, toward_minus_x * spec_.close_speed_mps * kUnitsPerMeter);
  }
}

double JawHand::opening_m() const {
  const btVector3 apart =
      fingers_[1]->getCenterOfMassPosition() - fingers_[0]->getCenterOfMassPosition();
  return apart.dot(Column(*palm_, 0)) / kUnitsPerMeter - spec_.finger_size_m.x();
}

double JawHand::yielded_m() const {
  double minimum = 0;
  for (const auto& slide : slides_) minimum = std::min(minimum, slide->Displacement());
  return -minimum / kUnitsPerMeter;
}

// During the solver's run, the palm keeps its old pose and has exactly the velocity that takes it
// to its target, like the fingers. Bullet's kinematic bodies jump ahead by one step instead. Called
// after Bullet has set that velocity itself.
void JawHand::DrivePalm() {
  btVector3 linear, angular;
  btTransformUtil::calculateVelocity(palm_->getWorldTransform(), ToBullet(Pose(target_WG_ * X_GP_)),
                                     step_s_, linear, angular);
  palm_->setLinearVelocity(linear);
  palm_->setAngularVelocity(angular);
}

void JawHand::AfterStep(std::vector<PadFriction> frictions) {
  frictions_ = std::move(frictions);
  X_WG_ = target_WG_;
  const btTransform X_WP = ToBullet(Pose(X_WG_ * X_GP_));
  palm_->setWorldTransform(X_WP);
  palm_->setInterpolationWorldTransform(X_WP);
  ReadContacts();
}

void JawHand::ReadContacts() {
  forces_n_ = {0, 0};
  touched_.clear();
  for (int i = 0; i < 2; ++i) {
    for (const BodyContacts& contacts : ContactsOf(*fingers_[i], world_)) {
      if (contacts.other->getUserIndex() < 0) continue;
      const double force_n = NormalForce_n(*contacts.manifold, step_s_);
      forces_n_[i] += force_n;
      if (force_n > kTouch_n) touched_.push_back(contacts.other->getUserIndex());
    }
  }
  for (int i = 0; i < 2; ++i) {
    untouched_s_[i] = forces_n_[i] > kTouch_n ? 0 : untouched_s_[i] + step_s_;
  }
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
}

HandLoad JawHand::Load() const {
  HandLoad load;
  for (const btRigidBody* body : {fingers_[0].get(), fingers_[1].get(), palm_.get()}) {
    for (const BodyContacts& contacts : ContactsOf(*body, world_)) {
      if (contacts.other->getUserIndex() < 0) continue;
      const btPersistentManifold& manifold = *contacts.manifold;
      if (body == palm_.get()) load.stiff_n += NormalForce_n(manifold, step_s_);
      AddContactForces(manifold, manifold.getBody0() == body, X_WG_, step_s_, load);
    }
  }
  const Eigen::Matrix3d R_GW = X_WG_.linear().transpose();
  for (const PadFriction& friction : frictions_) {
    const Eigen::Vector3d force_n = R_GW * friction.force_n;
    load.force_n += force_n;
    load.torque_nm +=
        R_GW * friction.torque_nm + (X_WG_.inverse() * friction.place_m).cross(force_n);
  }
  return load;
}

}  // namespace

Hand& AddJawHand(PhysicsWorld& world, const HandSpec& spec, const Pose& X_WG) {
  auto hand = std::make_unique<JawHand>(world.bullet(), spec, X_WG, world.step_s());
  Hand& added = *hand;
  world.Attach(std::move(hand));
  return added;
}

std::vector<AxisAlignedBox> HandBoxes(const HandSpec& spec, double opening_m) {
  const Eigen::Vector3d half_finger = 0.5 * spec.finger_size_m;
  const double x = 0.5 * opening_m + half_finger.x();
  const double palm_z = -spec.finger_size_m.z() - 0.5 * spec.palm_size_m.z();
  return {{{-x, 0, -half_finger.z()}, half_finger},
          {{x, 0, -half_finger.z()}, half_finger},
          {{0, 0, palm_z}, 0.5 * spec.palm_size_m}};
}

}  // namespace pickbed::sim
