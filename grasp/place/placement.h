#pragma once

// Placement of a picked object on a table beside the bin, outside the wall at +x. The planner
// selects a resting direction that is probable, that the hand reaches without touching the table,
// and that lets the hand point down.

#include <span>
#include <vector>

#include "grasp/layer.h"
#include "scenes/base/settings.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

// Options of placement planning and of its execution.
struct PlaceOptions {
  double gap_m = 0.10;            // between bin and table
  double rim_clearance_m = 0.02;  // of hand and object above the rim of the bin during the carry
  double clearance_m = 0.001;     // of the hand above the table at release

  // The worth of a resting direction is its probability times the factors of the next three
  // options.
  double tilt_share = 0.5;  // lost if the hand points sideways instead of down
  double tip_rad = 0.5;  // inclination at release at which the worth is 0; the object tips the rest
  double good_drop_m = 0.005;  // drop height at release that halves the worth
  int tip_steps = 10;          // inclinations that are tried, from 0 to tip_rad

  double lower_mps = 0.4;       // peak speed of the descent to the table
  double slow_m = 0.010;        // height from which the descent is slow, until the table is felt
  double slow_mps = 0.03;       // speed of the slow descent
  double steady_s = 0.1;        // the hand rests before the slow descent to measure the weight
  double touch_n = 2;           // load taken by the table at which the descent stops
  double overtravel_m = 0.005;  // maximum descent below the height where contact is expected
  double release_mps = 0.02;    // of each finger at release
  void Visit(SettingsVisitor& v);
};

// Planned placement of one object.
struct PlacePlan {
  Pose X_WO = Pose::Identity();  // planned pose of the object on the table
  // Pose of the hand at release. The lowest side of the object touches the table, or stays above it
  // as far as the clearance of the hand requires.
  Pose X_WG = Pose::Identity();
  double overtravel_m = 0;  // distance that the hand may descend further before it meets the table
  AxisAlignedBox table_W;   // its top is the plane z = 0
};

// Plans the placement of an object with estimated pose X_WO when the hand closes at X_WG.
// `hand_boxes` are in G. If the object has no known resting directions, the six along the axes of O
// are used. Every direction also represents its images under the symmetries of the object.
PlacePlan PlanPlace(const Bin& bin, const ObjectModel& model, const Pose& X_WO, const Pose& X_WG,
                    std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options = {});

// Height of the origin of G from which hand and object clear the rim of the bin while the hand
// rotates from one pose to the other. X_GO: pose of the object in the hand.
double CarryHeight_m(const Bin& bin, const ObjectModel& model, const Pose& X_GO,
                     const Pose& X_WG_from, const Pose& X_WG_to,
                     std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options = {});

// Evaluates how well the object can be set down from each grasp X_OG, independent of where it was
// picked. `hand_boxes`: in G, by grasp. Returns 0..1 per grasp: the worth of the best resting
// direction, relative to the probability of the most probable one.
std::vector<double> SetDownWorths(const ObjectModel& model, std::span<const Pose> X_OG,
                                  std::span<const std::vector<AxisAlignedBox>> hand_boxes,
                                  const PlaceOptions& options = {});

// Difference between the planned and the final pose.
struct PlaceError {
  double distance_m = 0;  // of the center of mass
  double rotation_error_rad = 0;
};

// Returns the minimum rotation error over the symmetries of the object, and the distance for the
// same symmetry.
// - model: with which the placement was planned
// - X_WO_wanted, X_WO: planned and final pose
// - com_O: true center of mass; it differs from the model's if the object has another size
PlaceError PlaceErrorOf(const ObjectModel& model, const Pose& X_WO_wanted, const Pose& X_WO,
                        const Eigen::Vector3d& com_O);

}  // namespace pickbed::grasp
