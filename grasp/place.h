#pragma once

// Where a part that was picked is set down: on a table beside the bin, outside its wall at +x, in
// an orientation in which it can lie and which leaves the hand pointing down as far as it can.

#include <span>

#include "scenes/bin.h"
#include "scenes/object_model.h"
#include "scenes/pose.h"

namespace pickbed {

struct PlaceOptions {
  double gap_m = 0.10;         // between bin and table
  double clearance_m = 0.001;  // of hand and part above the table when the hand opens
};

struct PlacePlan {
  Pose X_WO = Pose::Identity();  // where the part is to lie
  Pose X_WG = Pose::Identity();  // where the hand opens: above that by what keeps it off the table
  AxisAlignedBox table_W;        // its top is the plane z = 0
};

// For a part that is believed at X_WO when the hand that stands at X_WG closes on it; `hand_boxes`
// in G. Where the part's resting directions are not known, the six along O's axes stand in.
PlacePlan PlanPlace(const Bin& bin, const ObjectModel& model, const Pose& X_WO, const Pose& X_WG,
                    std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options = {});

struct PlaceError {
  double distance_m = 0;  // of the centre of mass
  double turn_rad = 0;
};

// The least turn over the part's symmetries, with the distance that belongs to it.
PlaceError PlaceErrorOf(const ObjectModel& model, const Pose& X_WO_wanted, const Pose& X_WO);

}  // namespace pickbed
