#pragma once

// Early stop of the configurations of a sweep. A configuration ends when the interval of its pick
// success is at most ScenarioSpec::stop_width wide (eval/stats/sequential_stop.h). Scenes are
// evaluated in the order 0, 1, ..., in whatever order the workers finish them. Trials of later
// scenes that were running at that time are not counted.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/stats/sequential_stop.h"
#include "eval/trial/trial.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Progress of a configuration towards its early stop.
struct StopState {
  double width = 0;   // required width of the interval
  int bins = 0;       // evaluated, from 0 on; bins without an executed grasp do not affect the mean
  double mean = 0;    // pick success; all scenes have the same weight
  Interval interval;  // 95 % confidence sequence: valid at all times jointly
  bool reached = false;
};

// Counts the executed grasps of a trial and how many of them succeeded.
Cluster AttemptOutcomes(const TrialResult& trial);

// Stop rule of one configuration. It reorders the results, which can be added in any order.
class ConfigurationStop {
 public:
  explicit ConfigurationStop(double width) : stop_(width), width_(width) {}
  // Adds the outcomes of the executed grasps in a scene; an empty cluster for a crashed trial.
  void Add(BinIndex bin_index, const Cluster& outcome);
  // Returns whether the trial of this bin is part of the result.
  bool Counts(BinIndex bin_index) const { return !stop_.Reached() || bin_index < bins_; }
  StopState state() const;

 private:
  SequentialStop stop_;
  double width_;
  std::map<int, Cluster> later_;  // waiting for an earlier bin
  int bins_ = 0;
};

// Returns the stop state of one configuration from its trials and its crashed bins; nullopt if
// `width` is 0 (no early stop).
std::optional<StopState> StopOf(const std::vector<TrialResult>& trials,
                                const std::vector<BinIndex>& crashed_bins, double width);

// Formats as "stops after 23 bins: 0.912 in [0.871, 0.950], no wider than 0.080".
std::string StopText(const StopState& state);

}  // namespace pickbed::eval
