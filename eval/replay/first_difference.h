#pragma once

// Stage-by-stage comparison of two records of one attempt.

#include <string>

#include "eval/trial/trial.h"

namespace pickbed::eval {

// Returns the first value of a stage that differs, such as "hypotheses[2].score: 0.91 recorded,
// 0.92 replayed"; empty if the records agree. For scene and image, a record holds only the visible
// instances with their visible fractions and the hash. If these values agree, the text names what
// else the hash covers.
std::string WhatDiffers(TrialStage stage, const AttemptRecord& recorded,
                        const AttemptRecord& replayed);

}  // namespace pickbed::eval
