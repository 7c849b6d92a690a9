#pragma once

// Verifiers as plain numbers, one after the other, as model files hold them.

#include <cstddef>
#include <vector>

#include "perception/verify.h"

namespace pickbed {

std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers);

// `count` verifiers of equal shape that were trained on the first `features` of the features; those
// that came later count for nothing to them. Throws InputError when the numbers are not theirs.
std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count,
                                    int features = kVerifyFeatures);

// Of files from before bin, floor and neighbours were looked at, and before outlines were.
inline constexpr int kFeaturesWithoutSurroundings = 16, kFeaturesWithoutOutline = 19;

}  // namespace pickbed
