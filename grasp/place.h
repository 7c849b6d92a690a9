#pragma once

// Where a part that was picked is set down: on a table beside the bin, outside its wall at +x. Of
// the ways in which the part can rest, the one that is likely to last, that the hand reaches
// without meeting the table, and that leaves it pointing down.

#include <span>
#include <vector>

#include "scenes/bin.h"
#include "scenes/object_model.h"
#include "scenes/pose.h"
#include "scenes/settings.h"

namespace pickbed {

struct PlaceOptions {
  double gap_m = 0.10;            // between bin and table
  double rim_clearance_m = 0.02;  // of hand and part over the bin's rim on the way there
  double clearance_m = 0.001;     // of the hand above the table when it opens

  // A way to rest is worth its probability; each of these takes a share of that.
  double tilt_share = 0.5;  // lost by a hand that points to the side instead of down
  double tip_rad = 0.5;  // lost wholly by a part that is let go inclined by this and tips the rest
  double good_drop_m = 0.005;  // a part that is let go this high over the table is worth half
  int tip_steps = 10;          // inclinations that are looked at, from flat to tip_rad

  double lower_mps = 0.4;       // largest speed down to the table
  double slow_m = 0.010;        // from this high on it is lowered slowly, until the table is felt
  double slow_mps = 0.03;       // so fast
  double steady_s = 0.1;        // the hand stands still before that, to feel the weight
  double touch_n = 2;           // that the table takes from the hand: the part stands
  double overtravel_m = 0.005;  // below where it should be felt, at most
  double release_mps = 0.02;    // of each finger while it lets go
  void Visit(SettingsVisitor& v);
};

struct PlacePlan {
  Pose X_WO = Pose::Identity();  // where the part is to lie
  // Where the hand opens: the part touches the table with its low side, or stays above it by what
  // keeps the hand off.
  Pose X_WG = Pose::Identity();
  double overtravel_m = 0;  // that the hand may go on down before it meets the table
  AxisAlignedBox table_W;   // its top is the plane z = 0
};

// For a part that is believed at X_WO when the hand that stands at X_WG closes on it; `hand_boxes`
// in G. Where the part's resting directions are not known, the six along O's axes stand in; a
// direction stands for all that the part's symmetries make of it.
PlacePlan PlanPlace(const Bin& bin, const ObjectModel& model, const Pose& X_WO, const Pose& X_WG,
                    std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options = {});

// Height of G's origin from which on hand and part stay over the bin's rim by the clearance while
// the hand turns from one pose to the other. X_GO: the part in the hand.
double CarryHeight_m(const Bin& bin, const ObjectModel& model, const Pose& X_GO,
                     const Pose& X_WG_from, const Pose& X_WG_to,
                     std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options = {});

// How well a hand that holds the part at each of X_OG lays it down, 0..1, wherever it was picked:
// the worth of the best way to rest, of the likeliest one's. `hand_boxes` in G, by grasp.
std::vector<double> SetDownWorths(const ObjectModel& model, std::span<const Pose> X_OG,
                                  std::span<const std::vector<AxisAlignedBox>> hand_boxes,
                                  const PlaceOptions& options = {});

struct PlaceError {
  double distance_m = 0;  // of the centre of mass
  double turn_rad = 0;
};

// The least turn over the part's symmetries, with the distance that belongs to it.
PlaceError PlaceErrorOf(const ObjectModel& model, const Pose& X_WO_wanted, const Pose& X_WO);

}  // namespace pickbed
