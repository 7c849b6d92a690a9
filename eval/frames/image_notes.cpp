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
           "1 = the bin was given, or a table, floor or bin was recognised, or the estimator looks "
           "for none; 0 = scores of poses on a table or wall may be too high"},
          {"warnings",
           "doubts about the image and differences from the training images, for which scores are "
           "lowered; separated by semicolons"}};
}

std::string DatasetImagesCsv(const std::vector<DatasetImageNote>& images) {
  std::string csv = HeaderLine(DatasetImageColumns());
  for (const DatasetImageNote& image : images) {
    csv += fmt::format("{},{},{},{:d},{}\n", image.scene_id, image.image_id, image.poses,
                       image.has_background,
                       CsvCell(fmt::format("{}", fmt::join(image.warnings, "; "))));
  }
  return csv;
}

}  // namespace pickbed::eval
