#pragma once

// Pose estimates in the results format of the BOP challenge
// (docs/bop_challenge_2019_results_format.md of the BOP toolkit): a CSV file, one line per
// estimate,
//   scene_id,im_id,obj_id,score,R,t,time
// R is row-wise and t in mm; spaces separate their numbers. The time in seconds is for the whole
// image and is the same on all its lines; -1 = unknown.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "scenes/geometry/pose.h"

namespace pickbed::eval {

struct DatasetEstimate {
  int scene_id = 0;
  int image_id = 0;
  int object_id = 0;
  double score = 0;
  Pose X_CO = Pose::Identity();
  double time_s = -1;      // for the whole image; -1 = unknown
  std::string place = {};  // line in a results file, "results.csv:3"; empty if not from a file
};

// Returns the text of a results file.
std::string WriteEstimates(const std::vector<DatasetEstimate>& estimates);
// Returns the columns of a results file.
ResultColumns EstimateColumns();

// Reads a results file. Throws InputError, which names the line, for a wrong header or number
// of columns, a value that is no finite number, and an R that is no rotation. Throws also if times
// within an image differ by more than 1 ms.
std::vector<DatasetEstimate> ReadEstimates(const std::filesystem::path& file);

}  // namespace pickbed::eval
