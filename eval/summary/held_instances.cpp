#include "eval/summary/held_instances.h"

#include <algorithm>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

RetentionStatistics RetentionOf(const std::vector<TrialResult>& trials) {
  ValueClusters loads_g(1);
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.outcome.retention_g >= 0) loads_g[0].push_back(attempt.outcome.retention_g);
    }
  }
  if (loads_g[0].empty()) return {};
  return {static_cast<int>(loads_g[0].size()),
          *std::min_element(loads_g[0].begin(), loads_g[0].end()), MedianOf(loads_g)};
}

DropTimes DropTimesOf(const std::vector<TrialResult>& trials) {
  ValueClusters times_s(1);
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.outcome.drop_time_s >= 0) times_s[0].push_back(attempt.outcome.drop_time_s);
    }
  }
  if (times_s[0].empty()) return {};
  return {static_cast<int>(times_s[0].size()), MedianOf(times_s)};
}

}  // namespace pickbed::eval
