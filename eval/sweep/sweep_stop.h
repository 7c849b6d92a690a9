#pragma once

// Early stop of all configurations of a sweep; eval/summary/early_stop.h has the rule of one
// configuration.

#include <map>
#include <string>

#include "eval/summary/early_stop.h"

namespace pickbed::eval {

struct Sweep;

// Stop rules of all configurations of a sweep.
class SweepStop {
 public:
  explicit SweepStop(const Sweep& sweep);
  // Returns whether any configuration may stop early.
  bool enabled() const { return !configurations_.empty(); }
  // Adds a finished trial.
  void Add(const TrialResult& result);
  // Adds the outcome of a trial. Returns true if its configuration ends with it.
  bool Add(int trial, const Cluster& outcome);
  // Returns whether the trial is part of the results.
  bool Counts(int trial) const;
  // Returns the progress, such as "2 of 3 configurations are narrow enough". For one configuration,
  // returns the current and the required interval width.
  std::string Note() const;

 private:
  const Sweep& sweep_;
  std::map<int, ConfigurationStop> configurations_;  // configurations with a stop width, by number
};

// Throws InputError if a configuration has a stop width. Shards cannot stop early, because a shard
// does not know the results of the others.
void RequireNoStop(const Sweep& sweep);

}  // namespace pickbed::eval
