#include "sim/physics_world.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/bullet_bridge.h"
#include "sim/contact_reuse_impl.h"
#include "sim/part_shapes_impl.h"
#include "sim/patch_friction_impl.h"
#include "sim/warm_contact_impl.h"

namespace pickbed {
namespace {

// A thinner floor is grown downward to this: a part may fall 8 mm in a step, more than a
// sheet-metal floor is thick, and would come out at the other side.
constexpr double kSolidFloor_m = 0.05;
// The funnel stands this much inside the bin's walls, so that nothing catches on the seam.
constexpr double kFunnelInset_m = 0.0005;
constexpr double kFunnelWall_m = 0.05;
constexpr double kTooFast_mps = 50;
// With a jaw, which weighs more than what it touches, a fixed number of iterations leaves forces
// far from what the laws ask, and the more so the longer the step: at 240 Hz and 20 of them a
// finger came down on parts of a pile with 30 N where it should have been stopped at 60, and
// closing pads sank into a tee by 2 mm. After these, its steps go on until no iteration changes the
// relative velocity at a contact or a joint by more than this, or a turn by 0.05 rad/s.
constexpr double kSolved_mps = 0.005;
constexpr int kMostIterations = 200;

struct Part {
  std::unique_ptr<btRigidBody> body;
  const ObjectModel* model = nullptr;
  Pose X_BO;
  double radius = 0;        // of the part about its centre, Bullet units
  btTransform still_pose;   // where it was when it last moved noticeably
  double still_s = 0;       // how long ago that was
  btTransform looked_pose;  // where it was when its contacts were last looked for in full

  void Wake() {
    body->activate(true);
    still_s = 0;
  }
};

}  // namespace

struct PhysicsWorld::Impl {
  explicit Impl(const PhysicsOptions& physics_options);
  ~Impl();

  btRigidBody* AddStatic(std::unique_ptr<btCollisionShape> shape, const Pose& X_WB, double friction,
                         int group);
  btRigidBody* AddBox(const Pose& X_WB, const Eigen::Vector3d& half_size_m, double friction,
                      int group);
  void AddPieces(const std::vector<std::vector<Eigen::Vector3d>>& pieces_W, double friction);
  void LetTheStillFallAsleep();
  void TellWhichMoved();
  int WakeTouching(const btCollisionObject* body);  // how many

  const PhysicsOptions options;
  WarmContactConfiguration configuration;
  ReusingDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  PatchFrictionSolver solver{options.pad};
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  PartShapes part_shapes{options.hull_margin_m};
  std::vector<std::unique_ptr<btRigidBody>> statics;
  std::vector<btRigidBody*> funnel;  // in `statics` too, so that they live as long
  std::vector<Part> parts;
  std::unique_ptr<BulletHand> hand;
  long steps = 0;
  bool may_sleep = true;
  bool contacts_forgotten = false;
};

PhysicsWorld::Impl::Impl(const PhysicsOptions& physics_options) : options(physics_options) {
  world.setGravity(ToBullet(options.gravity_W));
  world.setForceUpdateAllAabbs(!options.awake_boxes_only);
  btContactSolverInfo& info = world.getSolverInfo();
  info.m_numIterations = options.solver_iterations;
  info.m_erp = info.m_erp2 = info.m_frictionERP = options.recover_share;
  // With one direction a gripped box slides out at eight times the force it needs.
  info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  if (options.contact_reuse_m > 0) {
    dispatcher.StartReuse(options.contact_reuse_m * kUnitsPerMeter);
  }
}

PhysicsWorld::Impl::~Impl() {
  hand.reset();
  for (int i = world.getNumCollisionObjects() - 1; i >= 0; --i) {
    world.removeCollisionObject(world.getCollisionObjectArray()[i]);
  }
}

btRigidBody* PhysicsWorld::Impl::AddStatic(std::unique_ptr<btCollisionShape> shape,
                                           const Pose& X_WB, double friction, int group) {
  shapes.push_back(std::move(shape));
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shapes.back().get());
  info.m_startWorldTransform = ToBullet(X_WB);
  info.m_friction = friction;
  statics.push_back(std::make_unique<btRigidBody>(info));
  world.addRigidBody(statics.back().get(), group, kPartGroup | kFingerGroup | kPalmGroup);
  return statics.back().get();
}

btRigidBody* PhysicsWorld::Impl::AddBox(const Pose& X_WB, const Eigen::Vector3d& half_size_m,
                                        double friction, int group) {
  return AddStatic(std::make_unique<btBoxShape>(ToBullet(half_size_m)), X_WB, friction, group);
}

// Without margins of their own, so that the surface is where the mesh has it; parts have theirs.
void PhysicsWorld::Impl::AddPieces(const std::vector<std::vector<Eigen::Vector3d>>& pieces_W,
                                   double friction) {
  auto compound = std::make_unique<btCompoundShape>(true, static_cast<int>(pieces_W.size()));
  compound->setMargin(0);
  for (const std::vector<Eigen::Vector3d>& corners : pieces_W) {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& p_W : corners) hull->addPoint(ToBullet(p_W), false);
    hull->setMargin(0);
    hull->recalcLocalAabb();
    compound->addChildShape(btTransform::getIdentity(), hull.get());
    shapes.push_back(std::move(hull));
  }
  AddStatic(std::move(compound), Pose::Identity(), friction, kStaticGroup);
}

// Bullet's own waiting time is a process-wide variable of 2 s. It is left alone, so that worlds
// cannot disturb each other; a body that has been slow or still for our time is told that it has
// been slow for longer than that.
void PhysicsWorld::Impl::LetTheStillFallAsleep() {
  constexpr double kLongerThanBulletWaits_s = 1e3;
  // Trembling may be this much faster than the speeds.
  constexpr double kLinearTremble = 4;
  constexpr double kAngularTremble = 20;
  // Slower than one step of free fall, so that a part that loses its support is seen to move.
  const double falling_mps = 0.99 * options.gravity_W.norm() / options.rate_hz;
  const double tremble_mps = std::min(kLinearTremble * options.sleep_linear_mps,
                                      std::max(options.sleep_linear_mps, falling_mps));
  for (Part& part : parts) {
    if (part.body->isStaticObject()) continue;
    const btTransform& pose = part.body->getWorldTransform();
    part.still_s += 1 / options.rate_hz;
    if (!part.body->isActive() ||
        Movement(part.still_pose, pose, part.radius) > options.still_m * kUnitsPerMeter) {
      part.still_pose = pose;
      part.still_s = 0;
    }
    if (!part.body->isActive()) continue;
    const bool still = part.still_s >= options.sleep_after_s;
    part.body->setSleepingThresholds(
        (still ? tremble_mps : options.sleep_linear_mps) * kUnitsPerMeter,
        (still ? kAngularTremble : 1) * options.sleep_angular_radps);
    if (still || part.body->getDeactivationTime() >= options.sleep_after_s) {
      part.body->setDeactivationTime(kLongerThanBulletWaits_s);
    }
  }
}

void PhysicsWorld::Impl::TellWhichMoved() {
  dispatcher.moved.assign(parts.size(), false);
  for (size_t i = 0; i < parts.size(); ++i) {
    const btTransform& pose = parts[i].body->getWorldTransform();
    const double moved = Movement(parts[i].looked_pose, pose, parts[i].radius);
    if (!contacts_forgotten && moved <= options.contact_reuse_m * kUnitsPerMeter) continue;
    parts[i].looked_pose = pose;
    dispatcher.moved[i] = true;
  }
  contacts_forgotten = false;
}

// Before a body goes: what leans on it must notice.
int PhysicsWorld::Impl::WakeTouching(const btCollisionObject* body) {
  int woken = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
    const bool is_first = manifold->getBody0() == body;
    if (manifold->getNumContacts() == 0 || !(is_first || manifold->getBody1() == body)) continue;
    const int other = (is_first ? manifold->getBody1() : manifold->getBody0())->getUserIndex();
    if (other < 0 || parts[other].body->isStaticObject()) continue;
    parts[other].Wake();
    ++woken;
  }
  return woken;
}

PhysicsWorld::PhysicsWorld(const PhysicsOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}
PhysicsWorld::~PhysicsWorld() = default;

void PhysicsWorld::AddBin(const Bin& bin) {
  if (bin.shape) {
    impl_->AddPieces(bin.shape->pieces_B, bin.friction);
    return;
  }
  const double grow_m = std::max(0.0, kSolidFloor_m - bin.wall_m);
  bool is_floor = true;
  for (AxisAlignedBox box : BinBoxes(bin)) {
    if (is_floor) {
      box.center.z() -= 0.5 * grow_m;
      box.half_size.z() += 0.5 * grow_m;
    }
    is_floor = false;
    AddStaticBox(Translation(box.center), box.half_size, bin.friction);
  }
}

void PhysicsWorld::AddStaticBox(const Pose& X_WB, const Eigen::Vector3d& half_size_m,
                                double friction) {
  impl_->AddBox(X_WB, half_size_m, friction, kStaticGroup);
}

int PhysicsWorld::AddPart(const ObjectModel& model, const Pose& X_WO, BodyMode mode,
                          const Twist& V_WO) {
  if (model.convex_parts_O.empty()) {
    throw std::logic_error("part '" + model.name + "' has no convex pieces");
  }
  const PartShape& shape = impl_->part_shapes.Of(model);
  const bool is_static = mode == BodyMode::kStatic;
  btRigidBody::btRigidBodyConstructionInfo info(is_static ? 0 : model.mass.mass_kg, nullptr,
                                                shape.shape);
  if (!is_static) {
    info.m_localInertia = kUnitsPerMeter * ToBullet(shape.frame.principal_inertia);
  }
  info.m_startWorldTransform = ToBullet(Pose(X_WO * shape.frame.X_OB));
  info.m_friction = model.friction;
  info.m_angularDamping = impl_->options.angular_damping;
  auto body = std::make_unique<btRigidBody>(info);
  body->setUserIndex(part_count());
  body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_HAS_FRICTION_ANCHOR);
  body->setLinearVelocity(ToBullet(V_WO.linear_W));
  body->setAngularVelocity(btVector3(V_WO.angular_W.x(), V_WO.angular_W.y(), V_WO.angular_W.z()));
  if (is_static) {
    impl_->world.addRigidBody(body.get(), kStaticGroup, kPartGroup | kFingerGroup | kPalmGroup);
  } else {
    impl_->world.addRigidBody(body.get(), kPartGroup,
                              kStaticGroup | kFunnelGroup | kPartGroup | kFingerGroup | kPalmGroup);
    if (!impl_->may_sleep) body->setActivationState(DISABLE_DEACTIVATION);
  }
  if (mode == BodyMode::kAsleep) body->forceActivationState(ISLAND_SLEEPING);
  const btTransform X_WB = body->getWorldTransform();
  impl_->dispatcher.radius.push_back(0.5 * model.diameter_m * kUnitsPerMeter);
  impl_->parts.push_back({std::move(body), &model, shape.frame.X_OB.inverse(),
                          0.5 * model.diameter_m * kUnitsPerMeter, X_WB, 0, X_WB});
  return part_count() - 1;
}

void PhysicsWorld::RemovePart(int part) {
  Part& entry = impl_->parts.at(part);
  if (!entry.body->isInWorld()) return;
  if (impl_->hand != nullptr) impl_->hand->LetGoOf(part);
  impl_->WakeTouching(entry.body.get());
  impl_->world.removeRigidBody(entry.body.get());
  entry.body->forceActivationState(ISLAND_SLEEPING);
}

void PhysicsWorld::AddFunnel(const Bin& bin, double height_m) {
  const Eigen::Vector2d inner =
      0.5 * bin.inner_size_m.head<2>() - Eigen::Vector2d::Constant(kFunnelInset_m);
  const double half_wall = 0.5 * kFunnelWall_m;
  const double z = bin.inner_size_m.z() + 0.5 * height_m;
  for (const double side : {-1.0, 1.0}) {
    impl_->funnel.push_back(impl_->AddBox(Translation({side * (inner.x() + half_wall), 0, z}),
                                          {half_wall, inner.y() + kFunnelWall_m, 0.5 * height_m},
                                          bin.friction, kFunnelGroup));
    impl_->funnel.push_back(impl_->AddBox(Translation({0, side * (inner.y() + half_wall), z}),
                                          {inner.x() + kFunnelWall_m, half_wall, 0.5 * height_m},
                                          bin.friction, kFunnelGroup));
  }
}

int PhysicsWorld::RemoveFunnel() {
  int woken = 0;
  for (btRigidBody* wall : impl_->funnel) {
    woken += impl_->WakeTouching(wall);
    impl_->world.removeRigidBody(wall);
  }
  impl_->funnel.clear();
  return woken;
}

Hand& PhysicsWorld::AddHand(const HandSpec& spec, const Pose& X_WG) {
  if (impl_->hand != nullptr) throw std::logic_error("the world has a hand already");
  impl_->hand = MakeBulletHand(impl_->world, spec, X_WG, step_s());
  impl_->solver.pads = impl_->hand->Pads();
  btContactSolverInfo& info = impl_->world.getSolverInfo();
  impl_->solver.least_iterations = info.m_numIterations;
  info.m_numIterations = std::max(info.m_numIterations, kMostIterations);
  // Bullet compares the square of the largest change, in its own units.
  info.m_leastSquaresResidualThreshold = std::pow(kSolved_mps * kUnitsPerMeter, 2);
  return *impl_->hand;
}

Hand& PhysicsWorld::AddCup(const CupSpec& spec, const Pose& X_WG) {
  if (impl_->hand != nullptr) throw std::logic_error("the world has a hand already");
  PartsInWorld parts{[this] { return part_count(); },
                     [this](int index) -> PartInWorld {
                       const Part& part = impl_->parts.at(index);
                       const bool is_there = part.body->isInWorld();
                       return {is_there ? part.body.get() : nullptr, part.model, part.X_BO};
                     }};
  impl_->hand = MakeBulletCup(impl_->world, spec, X_WG, step_s(), std::move(parts));
  return *impl_->hand;
}

void PhysicsWorld::Step() {
  if (impl_->may_sleep) impl_->LetTheStillFallAsleep();
  if (impl_->options.contact_reuse_m > 0) impl_->TellWhichMoved();
  impl_->solver.BeginStep();
  impl_->world.stepSimulation(step_s(), 0);
  if (impl_->hand != nullptr) impl_->hand->AfterStep(impl_->solver.frictions());
  ++impl_->steps;
}

double PhysicsWorld::time_s() const { return static_cast<double>(impl_->steps) * step_s(); }
double PhysicsWorld::step_s() const { return 1.0 / impl_->options.rate_hz; }
int PhysicsWorld::part_count() const { return static_cast<int>(impl_->parts.size()); }

Pose PhysicsWorld::X_WO(int part) const {
  const Part& entry = impl_->parts.at(part);
  return FromBullet(entry.body->getWorldTransform()) * entry.X_BO;
}

Twist PhysicsWorld::V_WO(int part) const {
  const btRigidBody& body = *impl_->parts.at(part).body;
  const btVector3& w = body.getAngularVelocity();
  return {FromBullet(body.getLinearVelocity()), {w.x(), w.y(), w.z()}};
}

bool PhysicsWorld::AllAsleep() const {
  return std::none_of(impl_->parts.begin(), impl_->parts.end(), [](const Part& part) {
    return !part.body->isStaticObject() && part.body->isActive();
  });
}

void PhysicsWorld::WakeAll() {
  for (Part& part : impl_->parts) {
    if (!part.body->isStaticObject() && part.body->isInWorld()) part.Wake();
  }
}

void PhysicsWorld::ForgetContacts() {
  impl_->dispatcher.ForgetContacts();
  impl_->contacts_forgotten = true;
  WakeAll();
}

void PhysicsWorld::ForbidSleep() {
  impl_->may_sleep = false;
  for (const Part& part : impl_->parts) {
    if (part.body->isStaticObject() || !part.body->isInWorld()) continue;
    part.body->forceActivationState(DISABLE_DEACTIVATION);
  }
}

bool PhysicsWorld::BlewUp() const {
  for (int i = 0; i < part_count(); ++i) {
    if (!impl_->parts[i].body->isInWorld()) continue;
    const double speed = V_WO(i).linear_W.norm();
    if (!X_WO(i).matrix().allFinite() || !(speed < kTooFast_mps)) return true;
  }
  return false;
}

std::vector<int> PhysicsWorld::PartsTouchingHand() const {
  return impl_->hand == nullptr ? std::vector<int>{} : impl_->hand->TouchedParts();
}

bool PhysicsWorld::PalmIsInside(double depth_m) const {
  const auto group = [](const btCollisionObject* body) {
    return body->getBroadphaseHandle()->m_collisionFilterGroup;
  };
  for (int i = 0; i < impl_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold* manifold = impl_->dispatcher.getManifoldByIndexInternal(i);
    if ((group(manifold->getBody0()) | group(manifold->getBody1())) !=
        (kPalmGroup | kStaticGroup)) {
      continue;
    }
    for (int k = 0; k < manifold->getNumContacts(); ++k) {
      if (manifold->getContactPoint(k).getDistance() < -depth_m * kUnitsPerMeter) return true;
    }
  }
  return false;
}

}  // namespace pickbed
