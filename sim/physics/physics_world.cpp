#include "sim/physics/physics_world.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/physics/body_shapes.h"
#include "sim/physics/bullet_types.h"
#include "sim/physics/contact_islands.h"
#include "sim/physics/contact_reuse.h"
#include "sim/physics/patch_friction.h"
#include "sim/physics/warm_contact.h"

namespace pickbed::sim {
namespace {

// A thinner floor is extended downward to this thickness. An instance may fall 8 mm in a step,
// which is more than the thickness of sheet metal, and would pass through.
constexpr double kSolidFloor_m = 0.05;
// The funnel is this much inside the bin's walls, so that nothing catches on the seam.
constexpr double kFunnelInset_m = 0.0005;
constexpr double kFunnelWall_m = 0.05;
constexpr double kTooFast_mps = 50;
// A jaw is heavier than the objects it touches. A fixed number of iterations then leaves large
// force errors, and more so with longer steps. At 240 Hz and 20 iterations, a finger pressed on
// instances in clutter with 30 N where 60 N should have stopped it. Closing pads sank 2 mm into a
// tee. So steps with a jaw iterate until no relative velocity at a contact or joint changes by more
// than this. For angular velocities the limit is 0.05 rad/s.
constexpr double kSolved_mps = 0.005;
constexpr int kMaxIterations = 200;

struct InstanceState {
  std::unique_ptr<btRigidBody> body;
  const ObjectModel* model = nullptr;
  double friction = 0;
  Pose X_BO;
  double radius = 0;         // of the object about its center, in Bullet's units
  btTransform still_pose;    // pose at the last noticeable movement
  double still_s = 0;        // time since that movement
  btTransform checked_pose;  // pose at the last contact search

  void Wake() {
    body->activate(true);
    still_s = 0;
  }
};

// Solver of a world with many sleeping bodies.
class AwakeSolver : public PatchFrictionSolver {
 public:
  AwakeSolver(const PadOptions& options, ReusingDispatcher& dispatcher)
      : PatchFrictionSolver(options), dispatcher_(dispatcher) {}

 protected:
  // Bullet visits the manifolds between these two calls.
  void prepareSolve(int, int) override { dispatcher_.ShowOnlyAwake(true); }
  void allSolved(const btContactSolverInfo&, btIDebugDraw*) override {
    dispatcher_.ShowOnlyAwake(false);
  }

 private:
  ReusingDispatcher& dispatcher_;
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
  void CountMoved();
  int WakeTouching(const btCollisionObject* body);  // returns how many

  const PhysicsOptions options;
  WarmContactConfiguration configuration;
  ReusingDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  AwakeSolver solver{options.pad, dispatcher};
  ContactIslandWorld world{dispatcher, broadphase, solver, configuration, options.wake_by_contact};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  BodyShapes body_shapes{options.hull_margin_m};
  std::vector<std::unique_ptr<btRigidBody>> statics;
  std::vector<btRigidBody*> funnel;  // also in `statics`, which owns them
  std::vector<InstanceState> instances;
  std::unique_ptr<AttachedHand> hand;
  long steps = 0;
  bool may_sleep = true;
  bool contacts_forgotten = false;
};

PhysicsWorld::Impl::Impl(const PhysicsOptions& physics_options) : options(physics_options) {
  CheckSettings("PhysicsOptions", options);
  world.setGravity(ToBullet(options.gravity_W));
  world.setForceUpdateAllAabbs(!options.awake_boxes_only);
  btContactSolverInfo& info = world.getSolverInfo();
  info.m_numIterations = options.solver_iterations;
  info.m_erp = info.m_erp2 = info.m_frictionERP = options.recover_share;
  // With one direction, a gripped box slides out at eight times the force it should need.
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
  world.addRigidBody(statics.back().get(), group,
                     kInstanceGroup | kDrivenHandGroup | kGuidedHandGroup);
  return statics.back().get();
}

btRigidBody* PhysicsWorld::Impl::AddBox(const Pose& X_WB, const Eigen::Vector3d& half_size_m,
                                        double friction, int group) {
  return AddStatic(std::make_unique<btBoxShape>(ToBullet(half_size_m)), X_WB, friction, group);
}

// The pieces have no margin, so that their surface is the mesh's surface. Instances have margins.
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

// Bullet's waiting time before sleep is a process-wide variable of 2 s. It is not changed, so that
// worlds do not affect each other. Instead, a body that was slow or still for sleep_after_s gets a
// larger deactivation time.
void PhysicsWorld::Impl::LetTheStillFallAsleep() {
  constexpr double kLongerThanBulletWaits_s = 1e3;
  // A vibrating body may exceed the sleep speeds by these factors.
  constexpr double kLinearTremble = 4;
  constexpr double kAngularTremble = 20;
  // Less than the speed gained in one step of free fall, so that an instance that loses its support
  // counts as moving.
  const double falling_mps = 0.99 * options.gravity_W.norm() / options.rate_hz;
  const double tremble_mps = std::min(kLinearTremble * options.sleep_linear_mps,
                                      std::max(options.sleep_linear_mps, falling_mps));
  for (InstanceState& instance : instances) {
    if (instance.body->isStaticObject()) continue;
    const btTransform& pose = instance.body->getWorldTransform();
    instance.still_s += 1 / options.rate_hz;
    if (!instance.body->isActive() ||
        Movement(instance.still_pose, pose, instance.radius) > options.still_m * kUnitsPerMeter) {
      instance.still_pose = pose;
      instance.still_s = 0;
    }
    if (!instance.body->isActive()) continue;
    const bool still = instance.still_s >= options.sleep_after_s;
    instance.body->setSleepingThresholds(
        (still ? tremble_mps : options.sleep_linear_mps) * kUnitsPerMeter,
        (still ? kAngularTremble : 1) * options.sleep_angular_radps);
    if (still || instance.body->getDeactivationTime() >= options.sleep_after_s) {
      instance.body->setDeactivationTime(kLongerThanBulletWaits_s);
    }
  }
}

void PhysicsWorld::Impl::CountMoved() {
  dispatcher.moved.assign(instances.size(), false);
  for (size_t i = 0; i < instances.size(); ++i) {
    const btTransform& pose = instances[i].body->getWorldTransform();
    const double moved = Movement(instances[i].checked_pose, pose, instances[i].radius);
    if (!contacts_forgotten && moved <= options.contact_reuse_m * kUnitsPerMeter) continue;
    instances[i].checked_pose = pose;
    dispatcher.moved[i] = true;
  }
  contacts_forgotten = false;
}

// Called before a body is removed, so that the bodies that lean on it wake up.
int PhysicsWorld::Impl::WakeTouching(const btCollisionObject* body) {
  int woken = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
    const bool is_first = manifold->getBody0() == body;
    if (manifold->getNumContacts() == 0 || !(is_first || manifold->getBody1() == body)) continue;
    const int other = (is_first ? manifold->getBody1() : manifold->getBody0())->getUserIndex();
    if (other < 0 || instances[other].body->isStaticObject()) continue;
    instances[other].Wake();
    ++woken;
  }
  return woken;
}

void PhysicsOptions::Visit(SettingsVisitor& v) {
  v.Real("rate_hz", rate_hz, {10, 100000}, "steps per second");
  v.Integer("solver_iterations", solver_iterations, {1, 100000}, "iterations of the solver");
  v.Vector3("gravity_W", gravity_W, {-1000, 1000}, "gravity in the world frame, m/s^2");
  v.Real("recover_share", recover_share, {0, 1},
         "share of overlaps and joint errors that is corrected per step");
  v.Real("hull_margin_m", hull_margin_m, {0, 0.01}, "distance by which hulls grow outward, m");
  v.Real("angular_damping", angular_damping, {0, 1},
         "share of the angular velocity that is lost per second");
  v.Real("sleep_linear_mps", sleep_linear_mps, {0, 100}, "speed below which a body sleeps, m/s");
  v.Real("sleep_angular_radps", sleep_angular_radps, {0, 1000},
         "angular velocity below which a body sleeps, rad/s");
  v.Real("sleep_after_s", sleep_after_s, {0, 2}, "time below both speeds until a body sleeps, s");
  v.Real("still_m", still_m, {0, 1}, "movement in this time below which a body sleeps too, m");
  v.Real("contact_reuse_m", contact_reuse_m, {0, 0.1},
         "movement up to which a pair keeps its contacts, m; 0 = contacts are always searched");
  v.Bool("awake_boxes_only", awake_boxes_only,
         "whether bounding boxes of sleeping and static bodies are not updated");
  v.Bool("wake_by_contact", wake_by_contact,
         "whether a hand wakes only the instances that it touches");
  v.Group(
      "pad", [this](SettingsVisitor& g) { pad.Visit(g); }, "contact settings of finger pads");
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

int PhysicsWorld::AddInstance(const ObjectModel& model, const Pose& X_WO, BodyMode mode,
                              const Twist& V_WO, const InstanceDeviation& deviation) {
  if (model.convex_pieces_O.empty()) {
    throw std::logic_error("object '" + model.name + "' has no convex pieces");
  }
  const BodyShape& shape = impl_->body_shapes.Of(model);
  const bool is_static = mode == BodyMode::kStatic;
  const double mass_factor = 1 + deviation.mass;
  const double friction = model.friction * (1 + deviation.friction);
  btRigidBody::btRigidBodyConstructionInfo info(is_static ? 0 : mass_factor * model.mass.mass_kg,
                                                nullptr, shape.shape);
  if (!is_static) {
    info.m_localInertia = kUnitsPerMeter * ToBullet(mass_factor * shape.frame.principal_inertia);
  }
  info.m_startWorldTransform = ToBullet(Pose(X_WO * shape.frame.X_OB));
  info.m_friction = friction;
  info.m_angularDamping = impl_->options.angular_damping;
  auto body = std::make_unique<btRigidBody>(info);
  body->setUserIndex(instance_count());
  body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_HAS_FRICTION_ANCHOR);
  body->setLinearVelocity(ToBullet(V_WO.linear_W));
  body->setAngularVelocity(btVector3(V_WO.angular_W.x(), V_WO.angular_W.y(), V_WO.angular_W.z()));
  if (is_static) {
    impl_->world.addRigidBody(body.get(), kStaticGroup,
                              kInstanceGroup | kDrivenHandGroup | kGuidedHandGroup);
  } else {
    impl_->world.addRigidBody(
        body.get(), kInstanceGroup,
        kStaticGroup | kFunnelGroup | kInstanceGroup | kDrivenHandGroup | kGuidedHandGroup);
    if (!impl_->may_sleep) body->setActivationState(DISABLE_DEACTIVATION);
  }
  if (mode == BodyMode::kAsleep) body->forceActivationState(ISLAND_SLEEPING);
  const btTransform X_WB = body->getWorldTransform();
  impl_->dispatcher.radius.push_back(0.5 * model.diameter_m * kUnitsPerMeter);
  impl_->instances.push_back({std::move(body), &model, friction, shape.frame.X_OB.inverse(),
                              0.5 * model.diameter_m * kUnitsPerMeter, X_WB, 0, X_WB});
  return instance_count() - 1;
}

void PhysicsWorld::RemoveInstance(int index) {
  InstanceState& entry = impl_->instances.at(index);
  if (!entry.body->isInWorld()) return;
  if (impl_->hand != nullptr) impl_->hand->LetGoOf(index);
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

void PhysicsWorld::Attach(std::unique_ptr<AttachedHand> hand) {
  if (impl_->hand != nullptr) throw std::logic_error("the world already has a hand");
  impl_->hand = std::move(hand);
  impl_->solver.pads = impl_->hand->Pads();
  if (impl_->solver.pads.empty()) return;
  btContactSolverInfo& info = impl_->world.getSolverInfo();
  impl_->solver.min_iterations = info.m_numIterations;
  info.m_numIterations = std::max(info.m_numIterations, kMaxIterations);
  // Bullet compares the square of the largest change, in its own units.
  info.m_leastSquaresResidualThreshold = std::pow(kSolved_mps * kUnitsPerMeter, 2);
}

btDiscreteDynamicsWorld& PhysicsWorld::bullet() { return impl_->world; }

InstanceBody PhysicsWorld::body(int index) const {
  const InstanceState& entry = impl_->instances.at(index);
  return {entry.body->isInWorld() ? entry.body.get() : nullptr, entry.model, entry.friction,
          entry.X_BO};
}

void PhysicsWorld::SetGravityOf(int index, const Eigen::Vector3d& gravity_W) {
  InstanceState& instance = impl_->instances.at(index);
  if (instance.body->isStaticObject()) return;
  instance.body->setGravity(ToBullet(gravity_W));
  instance.body->activate(true);
}

void PhysicsWorld::Step() {
  if (impl_->may_sleep) impl_->LetTheStillFallAsleep();
  if (impl_->options.contact_reuse_m > 0) impl_->CountMoved();
  impl_->solver.BeginStep();
  impl_->world.stepSimulation(step_s(), 0);
  if (impl_->hand != nullptr) impl_->hand->AfterStep(impl_->solver.frictions());
  ++impl_->steps;
}

double PhysicsWorld::time_s() const { return static_cast<double>(impl_->steps) * step_s(); }
double PhysicsWorld::step_s() const { return 1.0 / impl_->options.rate_hz; }
int PhysicsWorld::instance_count() const { return static_cast<int>(impl_->instances.size()); }

Pose PhysicsWorld::X_WO(int index) const {
  const InstanceState& entry = impl_->instances.at(index);
  return FromBullet(entry.body->getWorldTransform()) * entry.X_BO;
}

Twist PhysicsWorld::V_WO(int index) const {
  const btRigidBody& body = *impl_->instances.at(index).body;
  const btVector3& w = body.getAngularVelocity();
  return {FromBullet(body.getLinearVelocity()), {w.x(), w.y(), w.z()}};
}

bool PhysicsWorld::AllAsleep() const {
  return std::none_of(impl_->instances.begin(), impl_->instances.end(),
                      [](const InstanceState& instance) {
                        return !instance.body->isStaticObject() && instance.body->isActive();
                      });
}

void PhysicsWorld::WakeAll() {
  for (InstanceState& instance : impl_->instances) {
    if (!instance.body->isStaticObject() && instance.body->isInWorld()) instance.Wake();
  }
}

void PhysicsWorld::ForgetContacts() {
  impl_->dispatcher.ForgetContacts();
  impl_->contacts_forgotten = true;
  WakeAll();
}

void PhysicsWorld::ForbidSleep() {
  impl_->may_sleep = false;
  for (const InstanceState& instance : impl_->instances) {
    if (instance.body->isStaticObject() || !instance.body->isInWorld()) continue;
    instance.body->forceActivationState(DISABLE_DEACTIVATION);
  }
}

bool PhysicsWorld::BlewUp() const {
  for (int i = 0; i < instance_count(); ++i) {
    if (!impl_->instances[i].body->isInWorld()) continue;
    const double speed = V_WO(i).linear_W.norm();
    if (!X_WO(i).matrix().allFinite() || !(speed < kTooFast_mps)) return true;
  }
  return false;
}

std::vector<int> PhysicsWorld::InstancesTouchingHand() const {
  return impl_->hand == nullptr ? std::vector<int>{} : impl_->hand->TouchedInstances();
}

bool PhysicsWorld::HandIsInside(double depth_m) const {
  const auto group = [](const btCollisionObject* body) {
    return body->getBroadphaseHandle()->m_collisionFilterGroup;
  };
  for (int i = 0; i < impl_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold* manifold = impl_->dispatcher.getManifoldByIndexInternal(i);
    if ((group(manifold->getBody0()) | group(manifold->getBody1())) !=
        (kGuidedHandGroup | kStaticGroup)) {
      continue;
    }
    for (int k = 0; k < manifold->getNumContacts(); ++k) {
      if (manifold->getContactPoint(k).getDistance() < -depth_m * kUnitsPerMeter) return true;
    }
  }
  return false;
}

}  // namespace pickbed::sim
