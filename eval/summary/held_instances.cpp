#include "eval/summary/held_instances.h"

#include <algorithm>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

namespace {

// Returns this value of all attempts that have it. A negative one was not measured.
ValueClusters Measured(const std::vector<TrialResult>& trials, double GraspOutcome::*value) {
  ValueClusters measured(1);
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.outcome.*value >= 0) measured[0].push_back(attempt.outcome.*value);
    }
  }
  return measured;
}

}  // namespace

RetentionStatistics RetentionOf(const std::vector<TrialResult>& trials) {
  const ValueClusters loads_g = Measured(trials, &GraspOutcome::retention_g);
  const std::vector<double>& all_g = loads_g[0];
  if (all_g.empty()) return {};
  return {static_cast<int>(all_g.size()), *std::min_element(all_g.begin(), all_g.end()),
          MedianOf(loads_g)};
}

DropTimes DropTimesOf(const std::vector<TrialResult>& trials) {
  const ValueClusters times_s = Measured(trials, &GraspOutcome::drop_time_s);
  if (times_s[0].empty()) return {};
  return {static_cast<int>(times_s[0].size()), MedianOf(times_s)};
}

}  // namespace pickbed::eval
