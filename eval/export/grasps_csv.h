#pragma once

// Grasp candidates as a CSV table for other programs, one line per grasp.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "grasp/grasp.h"

namespace pickbed::eval {

inline constexpr char kGraspsFile[] = "grasps.csv";

// Returns one line per candidate, in the given order, with X_OG in m.
std::string GraspsCsv(const std::vector<GraspCandidate>& candidates);
// Returns the columns of GraspsCsv().
ResultColumns GraspsColumns();

}  // namespace pickbed::eval
