#pragma once

// The joints that grippers are made of: a palm driven along a path, and two fingers on sliders with
// a force limit, coupled left to right. A kinematic palm, fingers on 6-dof constraints with a
// force-limited motor and one coupling row hold to 5 % of the analytic limit 2*mu*F = m*(g+a).
// Along the approach each finger rests on a stop with an overload slide, as hands are protected
// against collisions: pulled, it stands firm; pushed, it gives way at a set force. Without it the
// force of a blow would be the solver's: it grew with the rate of steps.
// The suction cup of sim/cup_joint.h has the same public face.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "scenes/bin.h"
#include "scenes/pose.h"

namespace pickbed {

// Frame G: z approach, x closing, origin midway between the finger tips' pads, at the tips' ends
// (so that the tips reach to z = 0 of G and the palm stands at negative z).
struct HandSpec {
  Eigen::Vector3d finger_size_m{0.010, 0.020, 0.050};  // x thickness, y width, z length
  Eigen::Vector3d palm_size_m{0.10, 0.04, 0.03};       // box behind the fingers
  double stroke_m = 0.08;                              // largest opening between the pads
  double finger_mass_kg = 0.2;
  double force_n = 40;           // of each finger on the part
  double close_speed_mps = 0.1;  // of each finger
  double pad_friction = 1.0;     // own value of the pair rule of scenes/friction.h
  double yield_n = 40;           // push against the approach at which a finger gives way
};

// What parts do to the hand, as a wrist's sensor has it, by contacts alone: the hand's own weight
// and inertia are left out. Of the last step.
struct HandLoad {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();    // of parts on the hand, in G
  Eigen::Vector3d torque_nm = Eigen::Vector3d::Zero();  // likewise, about G's origin
  // Normal force of parts on what does not give way: a palm, a stem.
  double stiff_n = 0;
};

class Hand {
 public:
  virtual ~Hand() = default;
  // Pose that the palm is to reach in the next step; call before every Step().
  virtual void MoveTo(const Pose& X_WG) = 0;
  // Fingers are held at this opening (position servo, full force). A cup: the vacuum is off.
  virtual void HoldOpening(double opening_m) = 0;
  // Fingers close with their speed and force limit until told otherwise. A cup: the vacuum is on,
  // and takes hold in the first step in which the lip seals; once lost, it needs HoldOpening first.
  virtual void Close() = 0;
  // Between the pads. A cup: what is left of the bellows' travel.
  virtual double opening_m() const = 0;
  virtual Pose X_WG() const = 0;
  // Normal contact force on each finger from parts, in the last step, N. A cup: of the lip (pressed
  // on the part by bellows or vacuum), and of stem and palm.
  virtual std::array<double, 2> ContactForces_n() const = 0;
  // Both pads touch a part, or did 20 ms ago. A cup: it is sealed on a part.
  virtual bool Holds() const = 0;
  virtual HandLoad Load() const = 0;
  // How far the finger that was pushed furthest stands back along z, see HandSpec::yield_n. What is
  // pushed away with less than that force leaves it where it is. A cup: 0.
  virtual double yielded_m() const = 0;
};

// The hand's boxes (left finger, right finger, palm) in G at an opening, for collision checks.
std::vector<AxisAlignedBox> HandBoxes(const HandSpec& spec, double opening_m);

}  // namespace pickbed
