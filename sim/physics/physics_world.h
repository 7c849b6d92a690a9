#pragma once

// A live Bullet world. It is built from plain data, stepped, read and destroyed within one
// function. Its state is never restored in place, because only a rebuilt world is reproducible bit
// by bit.
//
// Lengths inside are decimetres (sim/physics/bullet_types.h gives the reason). This interface uses
// SI units and frame W. The default settings were chosen by measurement: 240 Hz, 20 iterations, two
// friction directions, friction anchors, hull margin 0.5 mm (less for small objects).

#include <memory>
#include <vector>

#include "scenes/base/settings.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/contact.h"
#include "scenes/objects/object_model.h"
#include "scenes/scene.h"
#include "sim/layer.h"
#include "sim/physics/attached_hand.h"

class btDiscreteDynamicsWorld;
class btRigidBody;

namespace pickbed::sim {

// Simulation settings.
struct PhysicsOptions {
  double rate_hz = 240;
  int solver_iterations = 20;
  Eigen::Vector3d gravity_W{0, 0, -kGravity_mps2};  // m/s^2
  // Share of overlaps, friction drift and joint errors that is corrected per step; 0..1. Its
  // product with rate_hz is the correction speed per metre, 48/s. Change both to keep the same law.
  double recover_share = 0.2;
  double hull_margin_m = 0.0005;  // hulls grow outward by this; less for objects under 4 cm
  double angular_damping = 0;     // share of the angular velocity lost per second, 0..1
  double sleep_linear_mps = 0.01;
  double sleep_angular_radps = 0.1;
  double sleep_after_s = 0.5;  // time below both speeds before a body sleeps; at most 2 s
  // A body also sleeps if its surface stayed within this distance for sleep_after_s. Flat faces can
  // vibrate permanently by micrometres at more than the speeds above.
  double still_m = 0.0002;
  // Above 0: a pair of bodies keeps its contacts while both stay within this distance since the
  // last contact search, see sim/physics/contact_reuse.h. Friction and torsion were measured
  // without it. Outcomes of whole grasps are the same with it (tests/figures/execute_figures).
  double contact_reuse_m = 0;
  // Does not update the bounding boxes of sleeping and static bodies. This changes the order of
  // pairs, so the same seed gives other clutter scenes.
  bool awake_boxes_only = false;
  // A hand wakes only the instances that it touches, see sim/physics/contact_islands.h. Scenes
  // without a hand do not change.
  bool wake_by_contact = false;
  PadOptions pad{};
  void Visit(SettingsVisitor& v);
};

enum class BodyMode { kDynamic, kAsleep, kStatic };

// Velocity of a body in frame W.
struct Twist {
  Eigen::Vector3d linear_W = Eigen::Vector3d::Zero();   // m/s, of the center of mass
  Eigen::Vector3d angular_W = Eigen::Vector3d::Zero();  // rad/s
};

// An instance's body, for hands.
struct InstanceBody {
  btRigidBody* body = nullptr;         // null after the instance was removed
  const ObjectModel* model = nullptr;  // valid as long as AddInstance()'s argument
  double friction = 0;                 // the instance's value in PairFriction()
  Pose X_BO = Pose::Identity();        // B = frame of the Bullet body
};

// A bin, object instances and at most one hand, simulated in Bullet.
class PhysicsWorld {
 public:
  // Throws InputError for options out of range.
  explicit PhysicsWorld(const PhysicsOptions& options = {});
  ~PhysicsWorld();
  PhysicsWorld(const PhysicsWorld&) = delete;
  PhysicsWorld& operator=(const PhysicsWorld&) = delete;

  // Adds the bin as a static body at the world's origin: boxes, or the convex pieces of its shape.
  void AddBin(const Bin& bin);

  // Adds a static box, for slopes and tables. It cannot be moved or read.
  void AddStaticBox(const Pose& X_WB, const Eigen::Vector3d& half_size_m, double friction);

  // Adds an instance. Returns its index 0, 1, 2, ... in the order of adding; this order is part of
  // the state. `model` must outlive the world. `deviation` changes its friction and mass for this
  // instance. Throws std::logic_error if model.convex_pieces_O is empty.
  int AddInstance(const ObjectModel& model, const Pose& X_WO, BodyMode mode = BodyMode::kDynamic,
                  const Twist& V_WO = {}, const InstanceDeviation& deviation = {});

  // Removes an instance. It keeps its index, last pose and velocity, and counts as asleep. Bodies
  // that touched it wake up.
  void RemoveInstance(int index);

  // Adds static walls that keep falling instances above the bin's opening, `height_m` above the
  // rim.
  void AddFunnel(const Bin& bin, double height_m);
  int RemoveFunnel();  // returns how many instances leaned on it; they wake up

  // Attaches a hand, which the world then owns. With a hand that has pads, the solver iterates
  // until contacts and joints are solved. Throws std::logic_error if there is a hand already.
  void Attach(std::unique_ptr<AttachedHand> hand);
  // For hands, which add their bodies and joints themselves and remove them in their destructors.
  btDiscreteDynamicsWorld& bullet();
  InstanceBody body(int index) const;

  // Replaces gravity for one instance, m/s^2, and wakes it. A static instance does not change.
  void SetGravityOf(int index, const Eigen::Vector3d& gravity_W);

  void Step();
  double time_s() const;
  double step_s() const;
  int instance_count() const;
  Pose X_WO(int index) const;
  Twist V_WO(int index) const;
  // Returns whether all dynamic bodies sleep.
  bool AllAsleep() const;
  void WakeAll();

  // Deletes all contacts, as in a world rebuilt from the poses, and wakes all bodies. Bodies that
  // were held only by friction anchors slip then.
  void ForgetContacts();
  void ForbidSleep();

  // Returns true if a body's state is not finite or a body is faster than 50 m/s.
  bool BlewUp() const;

  // Returns the indices of the instances that the hand touches, ascending; see
  // AttachedHand::TouchedInstances().
  std::vector<int> InstancesTouchingHand() const;

  // Returns whether a guided body of the hand was deeper than `depth_m` in a fixed body (bin, box
  // or static instance) in the last step. A guided body is moved kinematically, so it feels no
  // force from them.
  bool HandIsInside(double depth_m) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::sim
