#pragma once

// Interface of a robot hand in a physics world. It follows a path, opens, closes and reports its
// load.

#include <Eigen/Core>
#include <array>

#include "scenes/geometry/pose.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Load by instances on the hand in the last step, like a wrist sensor. It contains contact forces
// only; the hand's own weight and inertia are excluded.
struct HandLoad {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();    // of instances on the hand, in G
  Eigen::Vector3d torque_nm = Eigen::Vector3d::Zero();  // in G, about the origin of G
  // Normal force on rigid bodies of the hand (palm, stem).
  double stiff_n = 0;
};

// A gripper in a physics world. Frame G is defined by each hand's header.
class Hand {
 public:
  virtual ~Hand() = default;
  // Sets the palm's pose at the end of the next step. Must be called before every Step().
  virtual void MoveTo(const Pose& X_WG) = 0;
  // Moves the fingers to an opening and holds them there (position servo, full force). Suction cup:
  // switches the vacuum off.
  virtual void HoldOpening(double opening_m) = 0;
  // Closes the fingers with limited speed and force until the next HoldOpening(). Suction cup:
  // switches the vacuum on. It holds from the first step in which the lip seals. After a failure,
  // it needs HoldOpening() first.
  virtual void Close() = 0;
  // Returns whether the closed hand holds as soon as it touches an instance. Such a hand closes
  // before it approaches, and stops where it holds. Suction cup: true.
  virtual bool HoldsOnContact() const { return false; }
  // Returns how far beyond the planned pose the hand may move on until it holds, m. Suction cup:
  // the travel of the bellows that remains at the planned pose. Other hands: 0.
  virtual double SearchTravel_m() const { return 0; }
  // Returns the opening between the pads. Suction cup: the remaining travel of the bellows.
  virtual double opening_m() const = 0;
  virtual Pose X_WG() const = 0;
  // Returns the normal contact force of instances on each finger in the last step, N. Suction cup:
  // the force on the lip (by bellows or vacuum), and on stem and palm.
  virtual std::array<double, 2> ContactForces_n() const = 0;
  // Returns whether both pads touch an instance, or did less than 20 ms ago. Suction cup: whether
  // it is sealed.
  virtual bool Holds() const = 0;
  virtual HandLoad Load() const = 0;
  // Returns the largest displacement of a finger along -z from its stop, see HandSpec::yield_n. A
  // push below that force does not move the finger. Suction cup: 0.
  virtual double yielded_m() const = 0;
};

}  // namespace pickbed::sim
