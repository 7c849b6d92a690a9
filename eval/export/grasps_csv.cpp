#include "eval/export/grasps_csv.h"

#include <fmt/format.h>

namespace pickbed::eval {

ResultColumns GraspsColumns() {
  ResultColumns columns;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      columns.push_back({fmt::format("r{}{}", row, col),
                         fmt::format("row {}, column {} of the rotation from the hand frame G to "
                                     "the object frame O, from 0; column {} is the {} axis of G",
                                     row, col, col, "xyz"[col])});
    }
  }
  AddColumns(
      {{"x_m", "origin of G in O, x"},
       {"y_m", "origin of G in O, y"},
       {"z_m", "origin of G in O, z"},
       {"width_m", "distance between the contacts"},
       {"depth_m", "distance of the center of the contacts behind the finger tips"},
       {"quality", "quality of the contacts", "0..1"},
       {"epsilon", "largest load that the grasp resists in every direction (Ferrari and Canny)",
        "weights of the object"},
       {"robust", "share of sampled errors under which the object is lifted", "0..1"}},
      columns);
  return columns;
}

std::string GraspsCsv(const std::vector<GraspCandidate>& candidates) {
  std::string text = HeaderLine(GraspsColumns());
  for (const GraspCandidate& candidate : candidates) {
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 3; ++col)
        text += fmt::format("{},", candidate.X_OG.linear()(row, col));
    }
    for (int axis = 0; axis < 3; ++axis)
      text += fmt::format("{},", candidate.X_OG.translation()[axis]);
    text += fmt::format("{},{},{},{},{}\n", candidate.width_m, candidate.depth_m, candidate.quality,
                        candidate.epsilon, candidate.robust);
  }
  return text;
}

}  // namespace pickbed::eval
