#pragma once

// Two records of one look, compared stage by stage.

#include <string>

#include "eval/trial.h"

namespace pickbed {

// The first number of a stage in which the records differ: "hypotheses[2].score: 0.91 recorded,
// 0.92 replayed". Of scene and image a record holds the parts in view with their visible fractions
// beside the hash; where these agree it is said what may differ. Else empty where they agree.
std::string WhatDiffers(TrialStage stage, const PickRecord& recorded, const PickRecord& replayed);

}  // namespace pickbed
