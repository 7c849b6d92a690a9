#pragma once

// Estimators whose scores are converted into probabilities. MakeEstimator() puts them around any
// row of the table.

#include <memory>

#include "perception/estimators/pose_estimator.h"
#include "perception/estimators/score_calibration.h"

namespace pickbed::perception {

// Returns an estimator that gives the poses of `inner` with the probability of their score. It
// keeps the original score in PoseHypothesis::raw_score, and leaves out poses with a probability
// below `min_probability`.
std::unique_ptr<PoseEstimator> MakeCalibrated(std::unique_ptr<PoseEstimator> inner,
                                              ScoreCurve curve, double min_probability);

// Returns an estimator that gives the poses of `inner` with a score from their rank in the image: 1
// for the best of n, 1 - 1/n for the next, and so on. For scores of an unknown scale, until they
// are calibrated. It keeps the original score in PoseHypothesis::raw_score.
std::unique_ptr<PoseEstimator> MakeRanked(std::unique_ptr<PoseEstimator> inner);

}  // namespace pickbed::perception
