#pragma once

// Poses from another program, in any language: a child process or a server (scenes/plugin). The
// poses are used as they come. Neither the refiner nor non-maximum suppression changes them.

#include <memory>

#include "perception/estimators/pose_estimator.h"

namespace pickbed::perception {

inline constexpr char kProcessName[] = "process";

// Starts the program of setup.spec.command, or connects to setup.spec.connect. One program serves
// all images of the estimator. An image for which it fails has EstimateResult::failure, and the
// program is started again for the next one. Throws InputError if the program does not start or
// refuses the setup.
std::unique_ptr<PoseEstimator> MakeProcessEstimator(const EstimatorSetup& setup);

}  // namespace pickbed::perception
