#include "eval/stats/isotonic.h"

#include <algorithm>
#include <cstdint>

namespace pickbed::eval {

std::vector<IsotonicBlock> PoolAdjacentViolators(std::span<const ScoredOutcome> outcomes) {
  struct Pool {
    double first, last;
    int hits, samples;
  };
  std::vector<ScoredOutcome> sorted(outcomes.begin(), outcomes.end());
  std::stable_sort(
      sorted.begin(), sorted.end(),
      [](const ScoredOutcome& a, const ScoredOutcome& b) { return a.score < b.score; });
  std::vector<Pool> pools;
  const auto join_last_two = [&] {
    const Pool last = pools.back();
    pools.pop_back();
    pools.back().last = last.last;
    pools.back().hits += last.hits;
    pools.back().samples += last.samples;
  };
  // Compares hits / samples without division.
  const auto rises = [](const Pool& a, const Pool& b) {
    return static_cast<int64_t>(a.hits) * b.samples < static_cast<int64_t>(b.hits) * a.samples;
  };
  for (size_t i = 0; i < sorted.size();) {
    Pool equal{sorted[i].score, sorted[i].score, 0, 0};
    for (; i < sorted.size() && sorted[i].score == equal.first; ++i) {
      equal.hits += sorted[i].success;
      ++equal.samples;
    }
    pools.push_back(equal);
    while (pools.size() > 1 && !rises(pools[pools.size() - 2], pools.back())) join_last_two();
  }
  std::vector<IsotonicBlock> blocks;
  for (const Pool& pool : pools) {
    blocks.push_back(
        {pool.first, pool.last, static_cast<double>(pool.hits) / pool.samples, pool.samples});
  }
  return blocks;
}

}  // namespace pickbed::eval
