#include "perception/estimators/finite_poses.h"

#include <cmath>

#include "scenes/base/finite_counts.h"

namespace pickbed::perception {

void DropNotFinite(std::vector<PoseHypothesis>& hypotheses) {
  const auto dropped = std::erase_if(hypotheses, [](const PoseHypothesis& hypothesis) {
    return !hypothesis.X_CO.matrix().allFinite() || !std::isfinite(hypothesis.score) ||
           !std::isfinite(hypothesis.raw_score.value_or(hypothesis.score));
  });
  CountNotFinite(FiniteBoundary::kPoses, static_cast<int64_t>(dropped));
}

}  // namespace pickbed::perception
