#include "perception/pose_estimator.h"

#include "perception/estimators/ppf.h"

namespace pickbed {
namespace {

constexpr EstimatorRow kRows[] = {
    {"ppf", "point pair features with ICP, OpenCV's surface matching", &MakePpfEstimator},
};

}  // namespace

std::span<const EstimatorRow> EstimatorTable() { return kRows; }

}  // namespace pickbed
