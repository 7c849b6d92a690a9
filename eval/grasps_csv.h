#pragma once

// Grasp candidates as a table for other programs. A line a grasp:
//   r00 ... r22      rotation of X_OG by rows: columns are the axes of frame G in the part's frame
//   x_m y_m z_m      origin of G in O
//   width_m depth_m  between the contacts; of their middle behind the finger tips
//   quality epsilon robust    see grasp/grasp.h

#include <string>
#include <vector>

#include "grasp/grasp.h"

namespace pickbed {

std::string GraspsCsv(const std::vector<GraspCandidate>& candidates);

}  // namespace pickbed
