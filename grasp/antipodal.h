#pragma once

// Antipodal grasp candidates on a part's mesh: pairs of surface points whose connecting line lies
// in both friction cones (Nguyen 1988), with approach directions around the closing axis.
//
// A pair alone says little about two flat pads, so each candidate is judged by what the pads would
// touch (grasp/pad_contact.h). Its quality, 0..1, is a product of: angle of the contacts inside the
// friction cone, share of the pad in contact, depth of the contact behind the tips, and torque of
// the part's weight about the closing line against the pads' torsional friction.

#include <Eigen/Core>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/object_model.h"
#include "scenes/random.h"

namespace pickbed {

struct AntipodalOptions {
  int candidates = 2000;        // wanted
  int max_samples = 20000;      // surface points tried at most
  int max_pairs = 1000;         // antipodal pairs that are looked at
  int approaches = 12;          // around the closing axis
  double cone_share = 0.8;      // of the friction cone's half angle that is used
  double straight_share = 0.5;  // of the rays go along the normal, the others fill the cone
  // How far the tips stand beyond the contact, m; shallow ones serve parts that lie on the floor.
  Eigen::Vector3d tips_beyond_m{0.014, 0.009, 0.004};
  double point_spacing_m = 0.002;  // of the surface points that pads and hand are tested on
  int min_points = 2000;           // of them, whatever the spacing: enough for a bolt
  int max_points = 8000;           // and no more: cheap for a drill
  // For parts that lie on the floor: on each way that the part rests (ObjectModel::resting_O)
  // grasps that close level and come straight down, or lean about the closing axis so that the palm
  // passes a wall, with tips that stay over the floor.
  int resting_candidates = 1500;      // wanted at most
  double resting_lean_rad = 0.25;     // between leans
  int resting_leans = 2;              // to each side
  int resting_turns = 24;             // of a continuous symmetry that are looked at
  double resting_level_rad = 0.1;     // pairs that lie as level as this are levelled
  double floor_gap_m = 0.0025;        // of their tips over the floor
  double resting_spacing_rad = 0.05;  // as spacing_rad
  double min_width_m = 0.002;         // thinner walls are left alone
  double touch_band_m = 0.0005;       // surface this near to the first touch is in contact
  double full_pad_share = 0.15;       // of a pad in contact that is as good as all of it
  double thin_pad_factor = 0.3;       // quality of a contact without area against a full one
  double good_depth_m = 0.008;        // of the contact's middle behind the tips, and more
  double off_center_share = 0.5;      // of the quality lost half a diameter off the centre of mass
  double own_margin_m = 0.001;        // between the open hand and the part itself
  double spacing_m = 0.004;           // candidates nearer than both spacings count as one
  double spacing_rad = 0.25;
  void Visit(SettingsVisitor& v);
};

// Empty when the part has no antipodal pair that fits the stroke: a result, not an error.
std::vector<GraspCandidate> AntipodalGrasps(const ObjectModel& model, const GripperSpec& gripper,
                                            Rng& rng, const AntipodalOptions& options = {});

}  // namespace pickbed
