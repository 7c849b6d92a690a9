#pragma once

// Interface of a hand that is attached to a physics world. The hands themselves are in sim/hands.

#include <Eigen/Core>
#include <vector>

#include "scenes/base/settings.h"
#include "sim/layer.h"

class btRigidBody;

namespace pickbed::sim {

// Contact settings of finger pads, see sim/physics/patch_friction.h.
struct PadOptions {
  double gives_m = 0.00025;  // compliance of the rubber: a surface this near touches; 0..0.001
  double outline_update_s = 1.0 / 30;  // interval after which a sticking patch's outline is updated
  void Visit(SettingsVisitor& v);
};

// Friction of a contact patch on a pad, in frame W; see sim/physics/patch_friction.h.
struct PadFriction {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_nm = Eigen::Vector3d::Zero();  // about place_m
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
};

// A hand in a physics world. Bodies of object instances have their index as Bullet's user index.
// All other bodies keep Bullet's -1.
class AttachedHand {
 public:
  virtual ~AttachedHand() = default;
  // Called after each step with the friction on the pads in that step.
  virtual void AfterStep(std::vector<PadFriction> frictions) = 0;
  // Returns the indices of the instances that the hand touches, ascending. Touching means a force
  // above 0.01 N in the last step.
  virtual std::vector<int> TouchedInstances() const = 0;
  // Returns the bodies with flat pads, for patch friction. Empty for a hand without pads.
  virtual std::vector<const btRigidBody*> Pads() const = 0;
  // Called before the instance is removed from the world.
  virtual void LetGoOf(int index) = 0;
};

}  // namespace pickbed::sim
