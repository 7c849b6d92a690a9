#include "perception/pose_estimator.h"

namespace pickbed {

std::span<const EstimatorRow> EstimatorTable() { return {}; }

}  // namespace pickbed
