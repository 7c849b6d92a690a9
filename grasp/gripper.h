#pragma once

// Interface of a gripper. Each mechanism is one class in grasp/grippers/ and one row of the table
// in grasp/grippers/table.cpp. The numbers of a gripper are in a file, assets/grippers/NAME.yaml.
//
// Frame G moves with the hand. Its origin is where the hand touches an object: midway between the
// tips of a jaw, in the center of the lip of a suction cup.
//
//     parallel jaw                    suction cup
//
//     +-----------+                    +-------+
//     |   palm    |                    | palm  |
//     +-+-------+-+                    +--+-+--+
//       |       |                         | |     stem
//       |       |   fingers               / \     bellows
//       |   G---|---> x  closing         +-G-+---> x  any direction in the plane of the lip
//           |                              |
//           v z  approach                  v z  approach
//
//     y completes the right-handed frame: it points to the reader.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grasp/layer.h"
#include "scenes/base/random.h"
#include "scenes/base/settings.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"

namespace pickbed::sim {
class Hand;          // sim/hands/hand.h
class PhysicsWorld;  // sim/physics/physics_world.h
}  // namespace pickbed::sim

namespace pickbed::grasp {

struct GraspCandidate;         // grasp/grasp.h
struct GraspCandidateOptions;  // grasp/candidates/candidates.h

// A gripper: its numbers, its shape, its hand in physics and its grasp candidates. An `opening` is
// the distance between the fingers; a mechanism without fingers ignores it.
class Gripper {
 public:
  std::string name;            // stem of the file
  double approach_m = 0.12;    // straight-line approach before the grasp
  double clearance_m = 0.003;  // kept between hand and anything else when planning

  virtual ~Gripper() = default;

  // Value of the key `mechanism` in the file, for example "parallel_jaw".
  virtual const char* mechanism() const = 0;
  // Meaning of x, y and z of G in words, for example "the closing direction".
  virtual std::array<const char*, 3> axes_G() const = 0;
  // What an object must have to be held, in words, for example "place that closes its lip".
  virtual const char* needs() const = 0;
  // Key numbers in a few words.
  virtual std::string Summary() const = 0;

  // Visits the numbers of the mechanism, then `approach_m` and `clearance_m`.
  void Visit(SettingsVisitor& v);
  // Throws InputError if the numbers contradict each other. The message begins with `source`.
  // Default: no check.
  virtual void Validate(const std::string& source) const;
  // Throws InputError if a number is out of range, or as Validate().
  void Check() const;
  // Returns all settings as YAML, the mechanism first. Cache keys and the identity of a run contain
  // this text.
  std::string SettingsText() const;
  // Like SettingsText, with the help of each key as a comment. `mechanisms`: the choices of the key
  // `mechanism`.
  std::string SettingsHelp(const std::vector<std::string>& mechanisms) const;

  // Returns the opening on the approach to an object with this width between the contacts, or
  // nullopt if the object is too wide.
  virtual std::optional<double> ApproachOpening_m(double width_m) const = 0;
  virtual double MaxOpening_m() const = 0;
  // Returns the opening on the approach; the maximum for an object that is too wide.
  double OpeningOrMax_m(double width_m) const {
    return ApproachOpening_m(width_m).value_or(MaxOpening_m());
  }
  // Returns the time from an opening until the hand is closed on nothing. Opening takes as long.
  virtual double TravelTime_s(double opening_m) const = 0;

  // Returns the gripper with its holding force (fingers, vacuum) multiplied by `factor` > 0.
  virtual std::shared_ptr<const Gripper> WithForce(double factor) const = 0;

  // Adds the hand to the world, which owns it. The hand is open by `opening_m` and cannot open
  // further in this world. Throws std::logic_error if the world has a hand already.
  virtual Hand& AddTo(PhysicsWorld& world, double opening_m, const Pose& X_WG) const = 0;

  // Returns the solid boxes of the hand in G at an opening, for collision checks. The last one is
  // the palm.
  virtual std::vector<AxisAlignedBox> Boxes(double opening_m) const = 0;
  // Returns compliant boxes in G. They are drawn but not checked for collisions. Default: none.
  virtual std::vector<AxisAlignedBox> SoftBoxes() const;
  // Returns the region in G where another object would be grasped together with the target.
  // Default: nullopt, there is no such region.
  virtual std::optional<AxisAlignedBox> RegionBetween(double opening_m) const;
  // Returns the maximum displacement across the closing direction at which the hand still holds the
  // object. Default: 0.
  virtual double MaxAside_m() const;

  // Returns whether the hand may pull an object aside while it lifts it (grasp/plan/lift_aside.h).
  // Default: false; the pull would bend the lip of a cup.
  virtual bool PullsAside() const;

  // Returns the weight of a held object as a share of the load that breaks the hold, for the pose
  // of the object in the hand and the direction of gravity in G (unit). 1 and more cannot be held.
  // Default: 0, the candidates have been tested with the weight in every direction.
  virtual double WeightShare(const ObjectModel& object, const Pose& X_GO,
                             const Eigen::Vector3d& down_G) const;

  // Returns the weight in N from which an object with this friction is too heavy.
  virtual double Capacity_n(double object_friction) const = 0;

  // Samples grasp candidates of an object in its frame O, and sets quality, epsilon and robust.
  // Returns an empty list if the gripper cannot hold the object. Callers use the free function
  // MakeCandidates() in grasp/candidates/candidates.h, which also sets `place_quality`.
  virtual std::vector<GraspCandidate> MakeCandidates(
      const ObjectModel& model, Rng& rng, const GraspCandidateOptions& options) const = 0;

 protected:
  // Range of all sizes. A size of zero would make a hand that touches nothing; no real gripper has
  // a size below a tenth of a millimetre.
  static constexpr Range kSize{1e-4, 1.0};

  Gripper() = default;
  Gripper(const Gripper&) = default;
  Gripper& operator=(const Gripper&) = default;

  // Visits the numbers of the mechanism.
  virtual void VisitOwn(SettingsVisitor& v) = 0;

 private:
  std::string WriteText(const std::vector<std::string>& mechanisms, bool with_help) const;
};

}  // namespace pickbed::grasp
