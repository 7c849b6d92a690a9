#include "grasp/grippers/parallel_jaw.h"

#include <fmt/format.h>

#include "scenes/check.h"

namespace pickbed {

void CheckParallelJaw(const GripperSpec& spec, const std::string& source) {
  const HandSpec& hand = spec.hand;
  CheckInput(2 * spec.clearance_m < hand.stroke_m,
             fmt::format("{}: clearance_m = {}: twice that must stay below the stroke_m of {}",
                         source, spec.clearance_m, hand.stroke_m));
  CheckInput(hand.palm_size_m.x() >= hand.stroke_m,
             fmt::format("{}: palm_size_m = [{}, {}, {}]: its x must be at least the stroke_m of "
                         "{}, since the open fingers hang from it",
                         source, hand.palm_size_m.x(), hand.palm_size_m.y(), hand.palm_size_m.z(),
                         hand.stroke_m));
}

std::optional<double> ParallelJawApproachOpening(const GripperSpec& spec, double width_m) {
  const double opening = width_m + 2 * spec.clearance_m;
  if (opening > spec.hand.stroke_m) return std::nullopt;
  return opening;
}

}  // namespace pickbed
