#pragma once

// A live Bullet world, local to one function: built from plain data, stepped, read, thrown away.
// Never restored in place, since only a rebuilt world repeats bit by bit.
//
// Inside, lengths are decimetres (see sim/bullet_bridge.h for why); everything here is SI and in
// frame W. Settings are measured ones: 240 Hz, 20 iterations, two friction directions, friction
// anchors, hull margin 0.5 mm (less for small parts).

#include <memory>
#include <vector>

#include "scenes/bin.h"
#include "scenes/gravity.h"
#include "scenes/object_model.h"
#include "scenes/pose.h"

namespace pickbed {

// How a finger's pad lies on a part, see sim/patch_friction_impl.h.
struct PadOptions {
  double gives_m = 0.00025;        // rubber gives way by this: surface so near touches; 0..0.001
  double look_again_s = 1.0 / 30;  // until the outline of a patch that sticks is renewed
  // Parts lighter than this share of a finger's mass need their contacts' impulses from the last
  // step in full; with heavier ones it would only make the normal force tremble at the limit.
  double light_share = 0.5;
};

struct PhysicsOptions {
  double rate_hz = 240;
  int solver_iterations = 20;
  Eigen::Vector3d gravity_W{0, 0, -kGravity_mps2};  // m/s^2
  // Of overlaps, drift of friction and errors of joints, undone in a step; 0..1. Another rate_hz
  // needs another share for the same law: their product is the speed per metre, 48/s.
  double recover_share = 0.2;
  double hull_margin_m = 0.0005;  // grows hulls outward; shrunk for parts under 4 cm
  double angular_damping = 0;     // share of the angular velocity lost in a second, 0..1
  double sleep_linear_mps = 0.01;
  double sleep_angular_radps = 0.1;
  double sleep_after_s = 0.5;  // below both speeds for this long; at most 2 s
  // A body whose surface stayed within this for sleep_after_s may sleep too, however it trembles:
  // flat faces can tremble for ever by microns at more than the speeds above.
  double still_m = 0.0002;
  // Above 0: two bodies that have both stayed within this since their contacts were last looked for
  // in full keep those contacts, see sim/contact_reuse_impl.h. The figures of friction and torsion
  // were measured without; with it verdicts of whole grasps are the same
  // (tests/figures/execute_figures).
  double contact_reuse_m = 0;
  // Boxes of bodies that sleep or are static are not looked at again. Another order of pairs
  // follows from it, and so other piles from the same seed.
  bool awake_boxes_only = false;
  PadOptions pad{};
};

enum class BodyMode { kDynamic, kAsleep, kStatic };

struct Twist {
  Eigen::Vector3d linear_W = Eigen::Vector3d::Zero();   // m/s, of the centre of mass
  Eigen::Vector3d angular_W = Eigen::Vector3d::Zero();  // rad/s
};

struct HandSpec;  // sim/hand_joints.h
struct CupSpec;   // sim/cup_joint.h
class Hand;

class PhysicsWorld {
 public:
  explicit PhysicsWorld(const PhysicsOptions& options = {});
  ~PhysicsWorld();
  PhysicsWorld(const PhysicsWorld&) = delete;
  PhysicsWorld& operator=(const PhysicsWorld&) = delete;

  // The bin, static, at the world's origin: boxes, or the convex pieces of its shape.
  void AddBin(const Bin& bin);

  // A static box, for inclines and tables. Returns nothing: it cannot be moved or read.
  void AddStaticBox(const Pose& X_WB, const Eigen::Vector3d& half_size_m, double friction);

  // Returns the body's index: 0, 1, 2, ... in the order of adding. The model's convex_parts_O must
  // not be empty (std::logic_error). Add order is part of the state.
  int AddPart(const ObjectModel& model, const Pose& X_WO, BodyMode mode = BodyMode::kDynamic,
              const Twist& V_WO = {});

  // Takes a part out: it keeps its index, last pose and velocity, and counts as asleep. What
  // touched it wakes.
  void RemovePart(int part);

  // Static walls that keep falling parts above the bin's opening, `height_m` above the rim.
  void AddFunnel(const Bin& bin, double height_m);
  int RemoveFunnel();  // returns how many parts leaned on it: they wake

  // Palm and two fingers, see sim/hand_joints.h. One hand a world; owned by the world.
  Hand& AddHand(const HandSpec& spec, const Pose& X_WG);
  // A suction cup in its place. It looks at the parts' meshes: the models given to AddPart must
  // live as long as the world.
  Hand& AddCup(const CupSpec& spec, const Pose& X_WG);

  void Step();
  double time_s() const;
  double step_s() const;
  int part_count() const;
  Pose X_WO(int part) const;
  Twist V_WO(int part) const;
  bool AllAsleep() const;
  void WakeAll();

  // Forgets all contacts, as in a world built anew from the poses, and wakes all: what only stood
  // by friction's memory slips now.
  void ForgetContacts();
  void ForbidSleep();

  // True when any body's state is not finite or faster than 50 m/s.
  bool BlewUp() const;

  // Parts that touch the fingers (force above 0.01 N in the last step), by index, ascending. A cup:
  // the part that its lip is on, and those that stem and palm touch.
  std::vector<int> PartsTouchingHand() const;

  // Whether the palm, or a cup's stem, stands deeper than this in something that cannot give way:
  // bin, box or static part. Driven along its path, it feels no force from them. Of the last step.
  bool PalmIsInside(double depth_m) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
