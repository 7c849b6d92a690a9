#pragma once

// Rehearses grasps of unknown objects: the hand picks up completed shapes in physics before the
// cell moves.
//
// The world of a rehearsal has one object on a plane. The plane is at the lowest point of the
// object or, if that is lower, 0.5 mm below the hand. So a rehearsal shows whether a hand can hold
// an object of this shape, but not what neighbors do to it. A completed shape is uncertain, so each
// grasp is rehearsed on the surfaces at two probabilities:
//
//        ______
//       |  __  |  low probability: a larger object, which a hand may hit
//       | |  | |
//       | |__| |  high probability: a smaller one, which it may miss
//       |______|

#include <map>
#include <optional>
#include <span>
#include <utility>

#include "grasp/completed/completed_object.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/base/settings.h"
#include "scenes/scenario/failure_reason.h"

namespace pickbed::grasp {

struct RehearsalOptions {
  Eigen::Vector2d surface_levels{kPossibleLevel, kSurfaceLevel};
  double tolerance_m = 0.0007;  // of the reduced surface from which the convex pieces are made
  int max_pieces = 16;          // convex pieces of an object
  double hold_s = 0.3;          // duration of the hold in the air
  double shake_s = 0.4;         // duration of the shake
  void Visit(SettingsVisitor& v);
};

// Shares of the rehearsals of a grasp that count, 0..1. In the others the hand holds the object.
struct RehearsalFailures {
  double hit = 0;   // the hand hits the object on its way
  double lost = 0;  // the object slips or drops out of the hand
};

class Rehearsal {
 public:
  // `shapes` must outlive the rehearsal. `X_BW` is the pose of the world in the frame of the bin.
  // `assumed` are the properties of the objects; its surface_level is not used. `bin_friction` is
  // Bin::friction of the plane. Throws InputError for options out of range.
  Rehearsal(std::span<const OccupancyShape> shapes, const Pose& X_BW,
            const CompletedObjectOptions& assumed, double bin_friction,
            const RehearsalOptions& options = {});

  // Rehearses a grasp in W at both levels, on the shape of ShapeBetween(). A rehearsal does not
  // count if the hand closes on nothing, since the shape may lack what the hand grasps, or if the
  // physics fails. Returns nullopt if none counts, or no shape is between the fingers. Makes the
  // objects that are needed for the first time. Equal inputs give equal results in any order of
  // calls.
  std::optional<RehearsalFailures> FailuresOf(const Grasp& grasp, const Gripper& tool);

  // Returns how a grasp ends on the surface of a shape at a level: kNone if the hand holds the
  // object, and kClosedOnNothing also if the surface encloses no volume. The hand lifts straight
  // up.
  FailureReason FailureOf(const Grasp& grasp, const Gripper& tool, int shape, double surface_level);

  // Returns the shape with the largest expected volume between the fingers; -1 = none, or a hand
  // without fingers.
  int ShapeBetween(const Grasp& grasp, const Gripper& tool) const;

 private:
  const std::optional<CompletedObject>& ObjectOf(int shape, double surface_level);

  std::span<const OccupancyShape> shapes_;
  Pose X_BW_;
  CompletedObjectOptions assumed_;
  double bin_friction_;
  RehearsalOptions options_;
  std::map<std::pair<int, double>, std::optional<CompletedObject>> objects_;  // with convex pieces
};

}  // namespace pickbed::grasp
