#pragma once

// Local patches described by an auto-encoder (networks/kehl.cpp), which vote through a code book;
// the votes are filtered to modes (vote_modes.h), and ICP, verifier and final set are those of
// `descriptor`. Kehl et al., ECCV 2016.

#include <filesystem>
#include <memory>

#include "perception/pose_estimator.h"

namespace pickbed {

// spec.model as a file, or as a name under assets/models; empty = kehl.pt there.
std::filesystem::path KehlModelFile(const EstimatorSpec& spec);

// Modes fast and hard as of descriptor. Throws InputError as MakeLearnedEstimator does.
std::unique_ptr<PoseEstimator> MakeKehlEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
