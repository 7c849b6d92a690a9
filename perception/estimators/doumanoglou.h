#pragma once

// Local patches of which a network regresses the pose (networks/doumanoglou.cpp): each votes for
// what it says, without a code book; clustering, ICP, verifier and final set are those of
// `descriptor`. Doumanoglou et al. 2016. The look-up of its features is estimator descriptor with
// its model.

#include <filesystem>
#include <memory>

#include "perception/pose_estimator.h"

namespace pickbed {

// spec.model as a file, or as a name under assets/models; empty = doumanoglou.pt there.
std::filesystem::path DoumanoglouModelFile(const EstimatorSpec& spec);

// Modes fast and hard as of descriptor. Throws InputError as MakeLearnedEstimator does.
std::unique_ptr<PoseEstimator> MakeDoumanoglouEstimator(const EstimatorSetup& setup);

// Two sources of hypotheses: estimator descriptor with the shipped model, whose patches vote also
// for the pose that doumanoglou's model regresses from them. Throws InputError also where the two
// were trained for patches of other sides.
std::unique_ptr<PoseEstimator> MakeUnionEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
