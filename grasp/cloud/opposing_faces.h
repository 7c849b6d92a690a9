#pragma once

// Antipodal pairs of faces on a height map: places where the fingers of a jaw fit beside measured
// surface on both sides, and where the two pads meet opposing faces.
//
// A slice is one row of the map at one height of the finger tips. In it, everything above the tips
// blocks the fingers. Between two free places, the pads close on the outermost measured cells:
//
//     height                  top
//       |            _____________
//       |   |       |  measured   |        |
//       |   | pad   |             |   pad  |
//       |   |___   L|             |R   ____|    tips: engagement = top - tips
//       |            \___________/              below the tips: any shape
//       +----------------------------------> x (closing)
//
// The contacts are rated by the friction cone of their faces: the angle in the plane of the map and
// the slope against the approach, both measured on the silhouette.

#include <vector>

#include "grasp/cloud/height_map.h"
#include "grasp/cloud/observed_surface.h"
#include "scenes/base/settings.h"
#include "sim/hands/jaw_hand.h"

namespace pickbed::grasp {

struct OpposingFacesOptions {
  double cell_m = 0.002;             // edge of a cell of the map
  double row_step_m = 0.004;         // distance of the slices
  double level_step_m = 0.004;       // distance of the heights of the finger tips
  double floor_gap_m = 0.003;        // lowest tips above the lowest surface
  double below_tips_m = 0.0015;      // solid this far below the tips does not block; for noise
  double min_engagement_m = 0.004;   // minimum height of measured surface above the tips
  double good_engagement_m = 0.012;  // height without loss
  double good_support_m = 0.012;     // width of the contact across the closing without loss
  // Share of the rows of a pad whose surface is near its contact: below the first value the pair is
  // rejected, from the second one there is no loss.
  double min_cover = 0.3;
  double good_cover = 0.7;
  double near_contact_m = 0.008;
  // Free space beside a wide object, in place of the clearance of the gripper.
  double tight_clearance_m = 0.001;
  double min_purity = 0.85;    // minimum share of the main segment between the pads
  double lever_m = 0.05;       // distance from the center of the segment that halves the score
  double max_shift_m = 0.012;  // of the hand from the center of the contacts, towards free space
  double good_room_m = 0.004;  // free space beside the fingers without loss
  double room_share = 0.3;     // share of the score that is lost without it
  double width_share = 0.3;    // share of the score that is lost at the full stroke
  double lean_margin = 0.2;    // of a slope seen from above, which is less accurate than an outline
  double height_share = 0.3;   // share of the score that the lowest segment loses
  void Visit(SettingsVisitor& v);
};

// A grasp on a map.
struct FacePair {
  double x_m = 0, y_m = 0, tips_m = 0;  // center of the hand and height of the tips, in the map
  double width_m = 0;                   // outer width that the hand must enclose, about x_m
  double score = 0;                     // 0..1
  int segment = kBackground;
};

// Slices of one map that were rejected, by cause.
struct FaceRejections {
  int no_room = 0;       // no free place beside the surface, or wider than the stroke
  int palm = 0;          // the palm would meet the surface
  int two_segments = 0;  // another segment between the pads
  int friction = 0;      // faces outside the friction cone
  int shallow = 0;       // too little measured surface above the tips
  void Add(const FaceRejections& other);
};

// Returns the face pairs of a map. `friction` is the assumed coefficient between pad and object.
std::vector<FacePair> FindFacePairs(const HeightMap& map,
                                    const std::vector<SurfaceSegment>& segments,
                                    const sim::HandSpec& hand, double clearance_m, double friction,
                                    const OpposingFacesOptions& options, FaceRejections& rejected);

}  // namespace pickbed::grasp
