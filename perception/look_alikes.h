#pragma once

// Poses in which a part nearly covers itself: a flange on its other side, a mug turned until its
// handle is hidden. ICP ends in one as readily as in another, and only a check of each tells which
// is right.

#include <vector>

#include "perception/model_points.h"
#include "perception/votes.h"

namespace pickbed {

struct LookAlikeOptions {
  double max_gap_diameters = 0.05;   // mean distance of the turned surface from the part's
  double min_move_diameters = 0.12;  // pose distance from the part's own poses, and from each other
  int most = 40;
};

// Moves S_O such that X_CO * S_O nearly covers X_CO, the best covering first: of the rotations of a
// cube and of turns by 15 degrees, in the part's principal and in its mesh's axes, each moved to
// where it covers the part best, those within the gap.
std::vector<Pose> LookAlikes(const ObjectModel& model, const ModelPoints& points,
                             const PoseDistance& distance, const LookAlikeOptions& options = {});

}  // namespace pickbed
