#pragma once

// Two records of one look, compared stage by stage.

#include <string>

#include "eval/trial.h"

namespace pickbed {

// The first number of a stage in which the records differ: "hypotheses[2].score: 0.91 recorded,
// 0.92 replayed". Empty where they agree, and for scene and image, of which a record holds the
// hash alone.
std::string WhatDiffers(TrialStage stage, const PickRecord& recorded, const PickRecord& replayed);

}  // namespace pickbed
