#pragma once

// Verifiers as plain numbers, one after the other, as model files hold them.

#include <cstddef>
#include <vector>

#include "perception/verify.h"

namespace pickbed {

std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers);

// `count` verifiers of equal shape. Throws InputError when the numbers are not theirs.
std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count);

}  // namespace pickbed
