#pragma once

// Tables of tested grasps.

#include <string>

#include "eval/grasps/grasp_file.h"
#include "eval/grasps/physics_trials.h"
#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

inline constexpr char kGraspTestsFile[] = "grasp_tests.csv";

// Returns the rates of the tests for the console: on the table, hold test, bins, and how well the
// confidence of the file predicts success.
std::string GraspTestsText(const GraspFile& file, const GraspTests& tests,
                           const GraspTestOptions& options);
// Returns grasp_tests.csv, one line per tested grasp.
std::string GraspTestsCsv(const GraspFile& file, const GraspTests& tests);
// Returns the columns of GraspTestsCsv().
ResultColumns GraspTestsColumns();

}  // namespace pickbed::eval
