#include "eval/summary/early_stop.h"

#include <fmt/format.h>

#include "eval/trial/counts_by_bin.h"

namespace pickbed::eval {

Cluster AttemptOutcomes(const TrialResult& trial) {
  Cluster outcome;
  SuccessOfAttempts()(trial, outcome);
  return outcome;
}

void ConfigurationStop::Add(BinIndex bin_index, const Cluster& outcome) {
  later_.emplace(bin_index, outcome);
  for (auto next = later_.find(bins_); next != later_.end() && !stop_.Reached();
       next = later_.find(bins_)) {
    stop_.Add(next->second);
    later_.erase(next);
    ++bins_;
  }
}

StopState ConfigurationStop::state() const {
  return {width_, bins_, stop_.mean(), stop_.interval(), stop_.Reached()};
}

std::optional<StopState> StopOf(const std::vector<TrialResult>& trials,
                                const std::vector<BinIndex>& crashed_bins, double width) {
  if (width == 0) return std::nullopt;
  ConfigurationStop stop(width);
  for (const BinIndex bin_index : crashed_bins) stop.Add(bin_index, {});
  for (const TrialResult& trial : trials) stop.Add(trial.bin_index, AttemptOutcomes(trial));
  return stop.state();
}

std::string StopText(const StopState& state) {
  const std::string interval = fmt::format("{:.3f} in [{:.3f}, {:.3f}]", state.mean,
                                           state.interval.low, state.interval.high);
  if (!state.reached) {
    return fmt::format("not narrow enough after {} bins: {}, requested width {:.3f}", state.bins,
                       interval, state.width);
  }
  return fmt::format("stops after {} bins: {}, no wider than {:.3f}", state.bins, interval,
                     state.width);
}

}  // namespace pickbed::eval
