#include "eval/cli/grasps_csv.h"

#include <fmt/format.h>

namespace pickbed::eval {

std::string GraspsCsv(const std::vector<GraspCandidate>& candidates) {
  std::string text =
      "r00,r01,r02,r10,r11,r12,r20,r21,r22,x_m,y_m,z_m,width_m,depth_m,quality,epsilon,robust\n";
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
