#pragma once

// Mutation of file contents: the same seed gives the same bytes.

#include <span>
#include <string>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Returns one of the seeds with one to four changes: flipped bits, other bytes, a cut end, a
// removed or repeated block, a number replaced by an extreme one, exchanged lines, or a block of
// another seed. `seeds` is not empty.
std::string Mutated(std::span<const std::string> seeds, Rng& rng);

}  // namespace pickbed::tests
