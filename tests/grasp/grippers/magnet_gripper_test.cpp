// A gripper mechanism that pickbed does not have, an electromagnet, from its file to an executed
// pick. The whole mechanism is in this file: its numbers, its hand in physics, its candidates and
// its row. No other file names it.

#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "grasp/candidates/candidates.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/requirements.h"
#include "grasp/grippers/table.h"
#include "grasp/plan/plan.h"
#include "scenes/geometry/mesh_query.h"
#include "sim/hands/suction_hand.h"
#include "sim/physics/bullet_types.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// Numbers of the magnet. The pole and the palm are square.
//
//     +-------+
//     | palm  |
//     +--+-+--+
//        | |    pole
//        +G+---> x
//         |     air gap
//         v z (approach)
struct MagnetSpec {
  double radius_m = 0.012;      // half the side of the pole
  double pole_length_m = 0.10;  // from the face to the palm
  double pull_n = 40;           // of a face that is covered with steel
  double reach_m = 0.002;       // largest air gap
  double gap_m = 0.001;         // air gap of a grasp
  double friction = 0.4;        // of the face
};

// Steel has 7850 kg/m^3, aluminium 2700.
constexpr double kSteel_kgpm3 = 7850;
bool IsSteel(const ObjectModel& model) {
  return model.mass.mass_kg > 0.9 * kSteel_kgpm3 * model.mass.volume_m3;
}

std::vector<AxisAlignedBox> MagnetBoxes(const MagnetSpec& spec) {
  const Vector3d half_pole(spec.radius_m, spec.radius_m, 0.5 * spec.pole_length_m);
  const Vector3d half_palm(0.03, 0.03, 0.02);
  return {{{0, 0, -half_pole.z()}, half_pole},
          {{0, 0, -spec.pole_length_m - half_palm.z()}, half_palm}};
}

// Share of the face that has surface within reach.
double CoveredShare(const MeshQuery& mesh_O, const Pose& X_OG, const MagnetSpec& spec) {
  constexpr int kSide = 7;
  int covered = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vector3d p_G(spec.radius_m * (2.0 * (i % kSide) / (kSide - 1) - 1),
                       spec.radius_m * (2.0 * (i / kSide) / (kSide - 1) - 1), 0);
    covered += mesh_O.Raycast(X_OG * p_G, X_OG.linear().col(2), 0, spec.reach_m).has_value();
  }
  return static_cast<double>(covered) / (kSide * kSide);
}

// The face carries a load like the ring of a suction cup; the pull is proportional to the covered
// share.
CupSpec RingOf(const MagnetSpec& spec, double covered) {
  CupSpec ring;
  ring.radius_m = spec.radius_m;
  ring.vacuum_n = covered * spec.pull_n;
  ring.moment_limit_nm = ring.vacuum_n * spec.radius_m;
  ring.friction = spec.friction;
  return ring;
}

// A kinematic body, and a joint that holds the instance until the load exceeds the magnet's
// strength.
class MagnetHand : public Hand, public AttachedHand {
 public:
  MagnetHand(PhysicsWorld& physics, const MagnetSpec& spec, const Pose& X_WG)
      : physics_(physics), world_(physics.bullet()), spec_(spec), X_WG_(X_WG), target_WG_(X_WG) {
    for (const AxisAlignedBox& box : MagnetBoxes(spec)) {
      boxes_.push_back(std::make_unique<btBoxShape>(ToBullet(box.half_size)));
      shape_.addChildShape(ToBullet(Translation(box.center)), boxes_.back().get());
    }
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, &shape_);
    info.m_startWorldTransform = ToBullet(X_WG);
    body_ = std::make_unique<btRigidBody>(info);
    body_->setActivationState(DISABLE_DEACTIVATION);
    body_->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    world_.addRigidBody(body_.get(), kGuidedHandGroup, kStaticGroup | kInstanceGroup);
    world_.setInternalTickCallback(
        [](btDynamicsWorld* w, btScalar) {
          static_cast<MagnetHand*>(w->getWorldUserInfo())->Drive();
        },
        this, true);
  }

  ~MagnetHand() override {
    world_.setInternalTickCallback(nullptr, nullptr, true);
    Release();
    world_.removeRigidBody(body_.get());
  }

  void MoveTo(const Pose& X_WG) override { target_WG_ = X_WG; }
  void HoldOpening(double) override {
    is_on_ = false;
    Release();
  }
  void Close() override { is_on_ = true; }
  double opening_m() const override { return 0; }
  Pose X_WG() const override { return X_WG_; }
  std::array<double, 2> ContactForces_n() const override { return {ring_.vacuum_n, stiff_n_}; }
  bool Holds() const override { return joint_ != nullptr; }
  HandLoad Load() const override { return {load_.force_n, load_.torque_nm, stiff_n_}; }
  double yielded_m() const override { return 0; }

  void AfterStep(std::vector<PadFriction>) override {
    X_WG_ = target_WG_;
    body_->setWorldTransform(ToBullet(X_WG_));
    body_->setInterpolationWorldTransform(ToBullet(X_WG_));
    if (joint_ != nullptr) {
      JudgeLoad();
    } else if (is_on_) {
      Attract();
    }
    stiff_n_ = ContactForce_n();
  }
  std::vector<int> TouchedInstances() const override {
    return held_ < 0 ? std::vector<int>() : std::vector<int>{held_};
  }
  std::vector<const btRigidBody*> Pads() const override { return {}; }
  void LetGoOf(int index) override {
    if (held_ == index) Release();
  }

 private:
  void Drive() {
    btVector3 linear, angular;
    btTransformUtil::calculateVelocity(body_->getWorldTransform(), ToBullet(target_WG_),
                                       physics_.step_s(), linear, angular);
    body_->setLinearVelocity(linear);
    body_->setAngularVelocity(angular);
  }

  // Takes the steel instance that covers the largest share of the face.
  void Attract() {
    double max_share = 0;
    int best = -1;
    for (int i = 0; i < physics_.instance_count(); ++i) {
      const InstanceBody instance = physics_.body(i);
      if (instance.body == nullptr || instance.body->isStaticObject() || !IsSteel(*instance.model))
        continue;
      const double covered = CoveredShare(MeshQuery(instance.model->mesh_O),
                                          physics_.X_WO(i).inverse() * X_WG_, spec_);
      if (covered > max_share) {
        max_share = covered;
        best = i;
      }
    }
    if (best < 0) return;
    held_ = best;
    const InstanceBody instance = physics_.body(best);
    ring_ = RingOf(spec_, max_share);
    friction_ = PairFriction(instance.model->friction, spec_.friction);
    const btTransform X_BG = instance.body->getWorldTransform().inverse() * ToBullet(X_WG_);
    joint_ = std::make_unique<btGeneric6DofSpring2Constraint>(*body_, *instance.body,
                                                              btTransform::getIdentity(), X_BG);
    for (int axis = 0; axis < 6; ++axis) joint_->setLimit(axis, 0, 0);
    joint_->setJointFeedback(&feedback_);
    feedback_ = {};
    X_WG_taken_ = X_WG_;
    has_moved_ = false;
    instance.body->forceActivationState(DISABLE_DEACTIVATION);
    world_.addConstraint(joint_.get(), true);
  }

  void Release() {
    if (joint_ == nullptr) return;
    world_.removeConstraint(joint_.get());
    joint_->getRigidBodyB().forceActivationState(ACTIVE_TAG);
    joint_.reset();
    held_ = -1;
    load_ = {};
    ring_.vacuum_n = 0;
  }

  // The joint carries no load until the hand moves, because the instance rests on the floor. The
  // load is a mean over about 20 ms.
  void JudgeLoad() {
    has_moved_ = has_moved_ || !X_WG_.isApprox(X_WG_taken_, 1e-9);
    if (!has_moved_) return;
    const btRigidBody& instance = joint_->getRigidBodyB();
    const Eigen::Matrix3d R_GW = X_WG_.linear().transpose();
    const Vector3d force_n = FromBullet(feedback_.m_appliedForceBodyB);
    const Vector3d torque_nm = FromBullet(feedback_.m_appliedTorqueBodyB) / kUnitsPerMeter;
    const Vector3d arm_m = FromBullet(instance.getCenterOfMassPosition()) - X_WG_.translation();
    const double share = physics_.step_s() / 0.02;
    load_.force_n -= share * (R_GW * force_n + load_.force_n);
    load_.torque_nm -= share * (R_GW * (torque_nm + arm_m.cross(force_n)) + load_.torque_nm);
    if (ShareOfLimit(ring_, friction_, load_) < 1) return;
    is_on_ = false;
    Release();
  }

  double ContactForce_n() const {
    double impulse = 0;
    btDispatcher& dispatcher = *world_.getDispatcher();
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      if (manifold.getBody0() != body_.get() && manifold.getBody1() != body_.get()) continue;
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        impulse += manifold.getContactPoint(k).getAppliedImpulse();
      }
    }
    return impulse / (physics_.step_s() * kUnitsPerMeter);
  }

  const PhysicsWorld& physics_;
  btDiscreteDynamicsWorld& world_;
  const MagnetSpec spec_;
  Pose X_WG_, target_WG_, X_WG_taken_ = Pose::Identity();
  std::vector<std::unique_ptr<btBoxShape>> boxes_;
  btCompoundShape shape_;
  std::unique_ptr<btRigidBody> body_;
  std::unique_ptr<btGeneric6DofSpring2Constraint> joint_;
  btJointFeedback feedback_;
  bool is_on_ = false;
  bool has_moved_ = false;  // since it took hold
  int held_ = -1;
  CupSpec ring_ = RingOf(MagnetSpec(), 0);
  double friction_ = 0, stiff_n_ = 0;
  LipLoad load_;
};

class MagnetGripper : public Gripper {
 public:
  MagnetSpec magnet;

  const char* mechanism() const override { return "magnet"; }
  std::array<const char*, 3> axes_G() const override {
    return {"x of the pole", "y of the pole", "the approach"};
  }
  const char* needs() const override { return "steel face as large as the pole"; }
  std::string Summary() const override { return fmt::format("pulls {:g} N", magnet.pull_n); }
  void Validate(const std::string& source) const override {
    CheckInput(magnet.gap_m < magnet.reach_m, source + ": gap_m must be below reach_m");
  }
  std::optional<double> ApproachOpening_m(double) const override { return 0; }
  double MaxOpening_m() const override { return 0; }
  double TravelTime_s(double) const override { return 0; }
  std::vector<AxisAlignedBox> Boxes(double) const override { return MagnetBoxes(magnet); }
  double Capacity_n(double) const override { return magnet.pull_n; }

  std::shared_ptr<const Gripper> WithForce(double factor) const override {
    auto gripper = std::make_shared<MagnetGripper>(*this);
    gripper->magnet.pull_n *= factor;
    return gripper;
  }

  Hand& AddTo(PhysicsWorld& world, double, const Pose& X_WG) const override {
    auto hand = std::make_unique<MagnetHand>(world, magnet, X_WG);
    Hand& added = *hand;
    world.Attach(std::move(hand));
    return added;
  }

  std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, Rng& rng,
                                             const GraspCandidateOptions& options) const override {
    if (!IsSteel(model)) return {};
    const MeshQuery mesh(model.mesh_O);
    const auto hold = [&](const Pose& X_OG, double factor) -> std::optional<WrenchSet> {
      const double covered = CoveredShare(mesh, X_OG, magnet);
      if (covered == 0) return std::nullopt;
      return CupWrenches(model, RingOf(magnet, covered), X_OG, -magnet.gap_m, factor,
                         options.robust.cone_edges);
    };
    std::vector<GraspCandidate> candidates;
    const SurfaceSamples samples = SampleSurface(model.mesh_O, options.suction.max_samples, rng);
    const Rng errors(rng.Next());
    for (size_t i = 0; i < samples.points.size(); ++i) {
      GraspCandidate candidate;
      Eigen::Matrix3d R_OG;
      R_OG.col(2) = -samples.normals[i];
      R_OG.col(0) = samples.normals[i].unitOrthogonal();
      R_OG.col(1) = R_OG.col(2).cross(R_OG.col(0));
      candidate.X_OG = MakePose(R_OG, samples.points[i] + magnet.gap_m * samples.normals[i]);
      if (CoveredShare(mesh, candidate.X_OG, magnet) < 1) continue;
      const double lever_m = (candidate.X_OG.inverse() * model.mass.com_O).head<2>().norm();
      candidate.quality = 1 - lever_m / model.diameter_m;
      candidate.epsilon = DepthOfZero(*hold(candidate.X_OG, 1)).lower;
      candidate.robust = RobustShare(model, candidate.X_OG, hold, errors, options.robust);
      candidates.push_back(candidate);
    }
    return candidates;
  }

 protected:
  void VisitOwn(SettingsVisitor& v) override {
    v.Real("radius_m", magnet.radius_m, kSize, "half the side of the pole, m");
    v.Real("pole_length_m", magnet.pole_length_m, kSize, "from the face to the palm, m");
    v.Real("pull_n", magnet.pull_n, {0.1, 1e4}, "of a face that is covered with steel, N");
    v.Real("reach_m", magnet.reach_m, kSize, "largest air gap, m");
    v.Real("gap_m", magnet.gap_m, kSize, "air gap of a grasp, m");
    v.Real("friction", magnet.friction, {0.01, 3}, "of the face");
  }
};

constexpr std::array<GripperRow, 1> kWithMagnet{
    {{"magnet", "an electromagnet that holds steel",
      []() -> std::unique_ptr<Gripper> { return std::make_unique<MagnetGripper>(); }}}};

// A plate of 10 x 8 x 1 cm: 0.63 kg of steel or 0.22 kg of aluminium.
const Vector3d kPlate_m(0.10, 0.08, 0.01);
std::shared_ptr<const ObjectModel> Plate(double density_kgpm3) {
  return BoxObject(kPlate_m, density_kgpm3 * kPlate_m.prod());
}

std::shared_ptr<const Gripper> LoadMagnet(const std::string& keys = "") {
  const TemporaryFolder folder;
  const auto file = folder.Write("magnet.yaml", "mechanism: magnet\n" + keys);
  return LoadGripper(file.string(), kWithMagnet);
}

GraspCandidateOptions FewMagnetCandidates() {
  GraspCandidateOptions options;
  options.antipodal.candidates = options.antipodal.max_pairs = 20;
  options.suction.max_samples = 100;
  options.robust.samples = 4;
  return options;
}

// Plans a grasp of the first of two plates in the bin, and executes it.
GraspOutcome PlanAndPick(const Gripper& gripper, double density_kgpm3) {
  const ObjectSet objects{Plate(density_kgpm3)};
  const Scene scene = BoxesOnFloor({{0, 0}, {0.11, 0.05}}, kPlate_m.z());
  Rng rng(1);
  // The candidates of the steel plate, so that another material is a failure of the pick.
  const std::vector<std::vector<GraspCandidate>> candidates{
      MakeCandidates(*Plate(kSteel_kgpm3), gripper, rng, FewMagnetCandidates())};
  std::vector<EstimatedPose> poses;
  for (const PosedObject& instance : scene.objects)
    poses.push_back({instance.object, instance.X_WO, 1});
  const std::array<int, 1> first{0};
  const PlanResult plan = PlanGrasps({scene.bin, poses, candidates, {}, objects, gripper, first});
  if (plan.grasps.empty()) {
    ADD_FAILURE() << "no grasp was planned";
    return {};
  }
  return ExecuteGrasp(scene, objects, plan.grasps.front(), gripper, InstanceId{10}).outcome;
}

TEST(MagnetGripper, PicksASteelPlateAndSetsItDown) {
  const auto gripper = LoadMagnet("pull_n: 30\n");
  EXPECT_EQ(gripper->Summary(), "pulls 30 N");
  EXPECT_NO_THROW(RequireFitsBin(*gripper, Bin()));
  EXPECT_NO_THROW(RequireCanCarry(*gripper, *Plate(kSteel_kgpm3)));
  const GraspOutcome outcome = PlanAndPick(*gripper, kSteel_kgpm3);
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kNone));
  EXPECT_EQ(outcome.picked_instance, 10);
  EXPECT_EQ(outcome.neighbors_displaced, 0);
  EXPECT_LT(outcome.slip_m, 5e-4);
  EXPECT_TRUE(outcome.verdicts[static_cast<int>(SuccessRule::kPlaced)]);
  // In the hold, the load on the magnet is the weight of the plate, along z of G.
  const double weight_n = kSteel_kgpm3 * kPlate_m.prod() * kGravity_mps2;
  EXPECT_NEAR(outcome.contact_force_n.norm(), weight_n, 0.02 * weight_n);
}

TEST(MagnetGripper, DoesNotHoldAluminium) {
  EXPECT_EQ(FailureName(PlanAndPick(*LoadMagnet(), 2700).failure),
            FailureName(FailureReason::kClosedOnNothing));
}

// The plate weighs 6.16 N. The acceleration of the lift and the lever of the weight add to that.
TEST(MagnetGripper, PullBelowTheLoadOfTheLiftLosesThePlate) {
  EXPECT_EQ(FailureName(PlanAndPick(*LoadMagnet("pull_n: 6.3\n"), kSteel_kgpm3).failure),
            FailureName(FailureReason::kSlipped));
  // At twice the weight the plate is lifted.
  EXPECT_EQ(PlanAndPick(*LoadMagnet("pull_n: 12\n"), kSteel_kgpm3).instances_risen, 1);
  EXPECT_THROW(RequireCanCarry(*LoadMagnet("pull_n: 6.1\n"), *Plate(kSteel_kgpm3)), InputError);
}

TEST(MagnetGripper, CandidatesAreSteelFacesUnderTheWholePole) {
  const auto gripper = LoadMagnet();
  Rng rng(1);
  const auto grasps = MakeCandidates(*Plate(kSteel_kgpm3), *gripper, rng, FewMagnetCandidates());
  ASSERT_GT(grasps.size(), 10u);
  for (const GraspCandidate& grasp : grasps) {
    EXPECT_NEAR(std::abs(grasp.X_OG.linear()(2, 2)), 1, 1e-9);  // the sides are too narrow
    EXPECT_LE(std::abs(grasp.X_OG.translation().x()), 0.5 * kPlate_m.x() - 0.011);
    EXPECT_GT(grasp.epsilon, 0);
  }
}

// A user finds out which gripper can hold the object. One is named, not all.
TEST(MagnetGripper, ObjectThatItCannotHoldIsRefused) {
  const TemporaryFolder folder;
  setenv("XDG_CACHE_HOME", folder.path().c_str(), 1);
  EXPECT_THAT(
      ErrorOf([&] { RequireCandidates(*Plate(2700), *LoadMagnet(), FewMagnetCandidates()); }),
      testing::AllOf(HasSubstr("object 'box' has no steel face as large as the pole for "
                               "gripper 'magnet'"),
                     HasSubstr("but cup_20mm_long has "), testing::Not(HasSubstr("cup_30mm"))));
  unsetenv("XDG_CACHE_HOME");
}

TEST(MagnetGripper, InvalidFilesAreRefused) {
  EXPECT_THAT(ErrorOf([] { LoadMagnet("stroke_m: 0.08\n"); }), HasSubstr("stroke_m"));
  EXPECT_THAT(ErrorOf([] { LoadMagnet("pull_n: 0\n"); }), HasSubstr(":2: pull_n = 0"));
  EXPECT_THAT(ErrorOf([] { LoadMagnet("gap_m: 0.003\n"); }), HasSubstr("gap_m must be below"));
  const TemporaryFolder folder;
  const auto file = folder.Write("magnet.yaml", "mechanism: magnet\n");
  EXPECT_THAT(ErrorOf([&] { LoadGripper(file.string()); }),
              HasSubstr("unknown mechanism 'magnet'"));
}

}  // namespace
}  // namespace pickbed::tests
