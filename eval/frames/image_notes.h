#pragma once

// Number of poses and warnings of each image of a data set, as a CSV file beside the results file.
// The poses of images with warnings are less reliable.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

struct DatasetImageNote {
  int scene_id = 0;
  int image_id = 0;
  size_t poses = 0;
  // False if the estimator looked for a table, floor or bin and recognised none, and for an image
  // without depth readings.
  bool has_background = false;
  // They are from CheckFrame(), about the region of interest, and from the estimator.
  std::vector<std::string> warnings;
};

// Returns the text of the file: one line per image.
std::string DatasetImagesCsv(const std::vector<DatasetImageNote>& images);
// Returns the columns of the file.
ResultColumns DatasetImageColumns();

}  // namespace pickbed::eval
