#pragma once

// Pose estimates as the BOP challenge exchanges them (docs/bop_challenge_2019_results_format.md of
// the BOP toolkit): a CSV file with a line an estimate,
//   scene_id,im_id,obj_id,score,R,t,time
// R row-wise and t in mm, their numbers separated by spaces; time in seconds is that of the whole
// image, the same on all its lines, -1 where it is unknown.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/pose.h"

namespace pickbed::bop {

struct Estimate {
  int scene_id = 0;
  int image_id = 0;
  int object_id = 0;
  double score = 0;
  Pose X_CO = Pose::Identity();
  double time_s = -1;
  std::string place = {};  // in a results file, "results.csv:3"
};

std::string WriteResults(const std::vector<Estimate>& estimates);

// Throws InputError with the line for another header, another number of columns, what is no finite
// number, what is no rotation, and times that differ within an image.
std::vector<Estimate> ReadResults(const std::filesystem::path& file);

}  // namespace pickbed::bop
