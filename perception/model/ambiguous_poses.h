#pragma once

// Ambiguous poses: poses in which an object nearly coincides with itself, for example a flange
// upside down, or a mug rotated until its handle is hidden. ICP converges to any of them, so each
// must be verified against the image.

#include <vector>

#include "perception/model/model_points.h"
#include "perception/model/pose_distance.h"

namespace pickbed::perception {

struct AmbiguousPoseOptions {
  double max_gap_diameters = 0.05;   // mean distance of the moved surface to the original surface
  double min_move_diameters = 0.12;  // pose distance to the symmetric poses and to each other
  int max_poses = 40;                // maximum number of poses returned
};

// Finds transforms S_O for which an object at X_CO * S_O nearly coincides with the object at X_CO.
// Candidates are the 24 cube rotations and multiples of 15 degrees, about the principal axes and
// the mesh axes. Each is translated to the best fit and kept if its mean gap is within the limit.
// Returns the best fit first.
std::vector<Pose> AmbiguousPoses(const ObjectModel& model, const ModelPoints& points,
                                 const PoseDistance& distance,
                                 const AmbiguousPoseOptions& options = {});

}  // namespace pickbed::perception
