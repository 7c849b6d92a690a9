#pragma once

// Isotonic regression of outcomes on a score: the increasing function with the smallest squared
// error. It is the base of score calibration (Zadrozny and Elkan 2002).

#include <span>
#include <vector>

#include "eval/stats/roc.h"

namespace pickbed::eval {

// Scores [first, last] with the same fitted rate.
struct IsotonicBlock {
  double first = 0, last = 0;
  double rate = 0;
  int samples = 0;
};

// Pools adjacent violators (Ayer et al. 1955). Equal scores are one block. Returns the blocks with
// rising scores and strictly rising rates; empty without outcomes.
std::vector<IsotonicBlock> PoolAdjacentViolators(std::span<const ScoredOutcome> outcomes);

}  // namespace pickbed::eval
