#pragma once

// Estimator that describes local patches with an autoencoder (networks/kehl.cpp). The patches vote
// through a codebook, and the votes are filtered to modes (vote_modes.h). ICP, verifier and pose
// selection are the same as for estimator descriptor. Kehl et al., ECCV 2016.

#include <memory>

#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"

namespace pickbed::perception {

// Entries of EstimatorTable(), with the same modes as estimator descriptor. Throws InputError as
// MakeLearnedEstimator does.
std::unique_ptr<PoseEstimator> MakeKehlEstimator(const EstimatorSetup& setup);
// Returns the training of estimator kehl.
std::unique_ptr<EstimatorTraining> MakeKehlTraining();

}  // namespace pickbed::perception
