#pragma once

// Grasp candidates as a CSV table for other programs, one line per grasp:
//   r00 ... r22      rotation matrix of X_OG, row by row; its columns are the axes of G in O
//   x_m y_m z_m      origin of G in O
//   width_m depth_m  distance of the contacts; distance of their center behind the finger tips
//   quality epsilon robust    see grasp/grasp.h

#include <string>
#include <vector>

#include "eval/layer.h"
#include "grasp/grasp.h"

namespace pickbed::eval {

std::string GraspsCsv(const std::vector<GraspCandidate>& candidates);

}  // namespace pickbed::eval
