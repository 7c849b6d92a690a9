#include "eval/frames/image_notes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

ResultColumns DatasetImageColumns() {
  return {{"scene_id", "scene of the image"},
          {"im_id", "image in its scene"},
          {"poses", "number of poses in the results file"},
          {"background_recognised",
           "0 = the estimator recognised no table, floor or bin, so scores of poses on them may be "
           "too high, or the image has no reading; else 1"},
          {"warnings",
           "warnings about the image, separated by |: doubtful files, empty region of interest, "
           "failure of the estimator, and differences from the training images, which lower the "
           "scores"}};
}

std::string DatasetImagesCsv(const std::vector<DatasetImageNote>& images) {
  std::string csv = HeaderLine(DatasetImageColumns());
  for (const DatasetImageNote& image : images) {
    csv += fmt::format("{},{},{},{:d},{}\n", image.scene_id, image.image_id, image.poses,
                       image.has_background,
                       CsvCell(fmt::format("{}", fmt::join(image.warnings, " | "))));
  }
  return csv;
}

}  // namespace pickbed::eval
