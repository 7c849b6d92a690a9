#pragma once

// Verifiers as plain numbers, one after the other, as model files hold them.

#include <cstddef>
#include <vector>

#include "perception/verify.h"

namespace pickbed {

std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers);

// What a verifier knows of: the first of the features, and all modes or the first for all of them.
struct VerifierLayout {
  int features = kVerifyFeatures;
  int calibrations = kCandidateModes;
};
// Of files from before bin, floor and neighbours were looked at, before outlines were, and before
// modes were calibrated apart.
inline constexpr VerifierLayout kWithoutSurroundings{16, 1}, kWithoutOutline{19, 1},
    kOneCalibration{20, 1};

// `count` verifiers of equal shape; features that came after theirs count for nothing to them.
// Throws InputError when the numbers are not theirs.
std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count,
                                    const VerifierLayout& layout = {});

}  // namespace pickbed
