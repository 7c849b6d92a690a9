#pragma once

// Estimator whose network regresses the object pose from a local patch (networks/doumanoglou.cpp).
// Each patch votes for its regressed pose, without a codebook. Clustering, ICP, verifier and pose
// selection are the same as for estimator descriptor. Doumanoglou et al. 2016. To look up its
// features in a codebook instead, use estimator descriptor with its model.

#include <memory>

#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"

namespace pickbed::perception {

// Entries of EstimatorTable(), with the same modes as estimator descriptor. Throws InputError as
// MakeLearnedEstimator does.
std::unique_ptr<PoseEstimator> MakeDoumanoglouEstimator(const EstimatorSetup& setup);
// Returns the training of estimator doumanoglou.
std::unique_ptr<EstimatorTraining> MakeDoumanoglouTraining();

// Entries of EstimatorTable(): estimator descriptor with the shipped model and a second source of
// votes: the poses that the model of doumanoglou regresses from the same patches. Throws InputError
// also if the models have different patch sides or channels.
std::unique_ptr<PoseEstimator> MakeUnionEstimator(const EstimatorSetup& setup);
// Returns the training of the union of both estimators.
std::unique_ptr<EstimatorTraining> MakeUnionTraining();

}  // namespace pickbed::perception
