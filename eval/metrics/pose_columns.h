#pragma once

// Columns of a pose in a CSV file: unit quaternion with qw >= 0, and translation.

#include <string>

#include "eval/metrics/result_columns.h"
#include "scenes/geometry/pose.h"

namespace pickbed::eval {

// Returns qw, qx, qy, qz, tx_m, ty_m, tz_m. `what` describes the pose, such as "estimated pose".
ResultColumns PoseColumns(const std::string& what);
// Cells of X_WO, the pose of the object frame O in the world frame W. Each begins with a comma.
std::string PoseCells(const scenes::Pose& X_WO);
// As many empty cells.
std::string EmptyPoseCells();

}  // namespace pickbed::eval
