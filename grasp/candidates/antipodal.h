#pragma once

// Antipodal grasp candidates on the mesh of an object: pairs of surface points whose connecting
// line is inside both friction cones (Nguyen 1988), with approach directions around the closing
// axis.
//
// A point pair is a weak model of two flat pads. So each candidate is evaluated on the surface that
// the pads would touch (grasp/candidates/pad_contact.h). Its quality, 0..1, is a product of four
// factors: angle of the contacts inside the friction cone, share of the pad in contact, depth of
// the contact behind the tips, and torque of the weight about the closing line relative to the
// torsional friction of the pads.

#include <Eigen/Core>
#include <vector>

#include "grasp/grasp.h"
#include "scenes/base/random.h"
#include "scenes/objects/object_model.h"
#include "sim/hands/jaw_hand.h"

namespace pickbed::grasp {

// Options of antipodal candidates.
struct AntipodalOptions {
  int candidates = 2000;        // maximum number of general candidates
  int max_samples = 20000;      // maximum number of surface points from which rays are cast
  int max_pairs = 1000;         // the search stops after this number of antipodal pairs
  int approaches = 12;          // approach directions around the closing axis
  double cone_share = 0.8;      // share of the half angle of the friction cone that may be used
  double straight_share = 0.5;  // share of rays along the normal; the others sample the cone
  // Distances of the tips beyond the contact, m. Small ones serve objects that rest on the floor.
  Eigen::Vector3d tips_beyond_m{0.014, 0.009, 0.004};
  double point_spacing_m = 0.002;  // spacing of the surface points for pad and collision tests
  int min_points = 2000;           // minimum number of these points, enough for a bolt
  int max_points = 8000;           // maximum number, limits the cost for a drill
  // Further candidates for objects that rest on the floor, for each resting direction
  // (ObjectModel::resting_O). They close horizontally and approach straight down, or lean about the
  // closing axis so that the palm clears a wall. Their tips stay above the floor.
  int resting_candidates = 1500;      // maximum number of resting candidates
  double resting_lean_rad = 0.25;     // angle between leans
  int resting_leans = 2;              // leans to each side
  int resting_rotations = 24;         // sampled rotations of a continuous symmetry
  double resting_level_rad = 0.1;     // pairs within this angle of horizontal are made horizontal
  double floor_gap_m = 0.0025;        // distance of the tips from the floor
  double resting_spacing_rad = 0.05;  // like spacing_rad, for resting candidates
  double min_width_m = 0.002;         // thinner walls are not grasped
  double touch_band_m = 0.0005;  // surface within this distance of the first touch is in contact
  double full_pad_share = 0.15;  // share of a pad in contact from which there is no loss
  double thin_pad_factor = 0.3;  // quality factor of a contact without area, relative to a full one
  double good_depth_m = 0.008;   // contact center this far behind the tips: no loss
  double off_center_share = 0.5;  // quality lost at half a diameter from the center of mass
  double own_margin_m = 0.0015;   // between the open hand and the object
  double spacing_m = 0.004;       // candidates closer than both spacings are duplicates
  double spacing_rad = 0.25;
  void Visit(SettingsVisitor& v);
};

// Samples antipodal candidates of an object for a parallel jaw, in O. `clearance_m`: kept between
// the open fingers and the object, on each side. Returns an empty list if no antipodal pair fits
// the stroke; this is not an error. Epsilon and robust are not set.
std::vector<GraspCandidate> AntipodalGrasps(const ObjectModel& model, const HandSpec& hand,
                                            double clearance_m, Rng& rng,
                                            const AntipodalOptions& options = {});

}  // namespace pickbed::grasp
