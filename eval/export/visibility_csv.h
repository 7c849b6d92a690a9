#pragma once

// Visible fraction of each instance in an image, as a CSV table for other programs.

#include <string>

#include "eval/cell/simulated_cell.h"
#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

inline constexpr char kVisibilityFile[] = "visible.csv";

// Returns one line per instance of the scene.
std::string VisibilityCsv(const Scene& scene, const Observation& view, const ObjectSet& objects);
// Returns the columns of VisibilityCsv().
ResultColumns VisibilityColumns();

}  // namespace pickbed::eval
