#include "eval/sweep/sweep_stop.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/sweep/sweep.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/error.h"

namespace pickbed::eval {

SweepStop::SweepStop(const Sweep& sweep) : sweep_(sweep) {
  for (const Configuration& configuration : sweep.configurations) {
    const double width = configuration.spec.stop_width;
    if (width > 0) configurations_.emplace(configuration.number, ConfigurationStop(width));
  }
}

void SweepStop::Add(const TrialResult& result) {
  const auto configuration = configurations_.find(result.configuration);
  if (configuration != configurations_.end())
    configuration->second.Add(result.bin_index, AttemptOutcomes(result));
}

bool SweepStop::Add(int trial, const Cluster& outcome) {
  const Configuration& owner = ConfigurationOf(sweep_, trial);
  const auto configuration = configurations_.find(owner.number);
  if (configuration == configurations_.end() || configuration->second.state().reached) return false;
  configuration->second.Add(BinIndex(trial - owner.first_trial), outcome);
  return configuration->second.state().reached;
}

bool SweepStop::Counts(int trial) const {
  const Configuration& owner = ConfigurationOf(sweep_, trial);
  const auto configuration = configurations_.find(owner.number);
  return configuration == configurations_.end() ||
         configuration->second.Counts(BinIndex(trial - owner.first_trial));
}

std::string SweepStop::Note() const {
  if (!enabled()) return "";
  if (configurations_.size() == 1) {
    const StopState state = configurations_.begin()->second.state();
    const double width = state.interval.high - state.interval.low;
    return fmt::format("{:.3f} wide, stops at {:.3f}", width, state.width);
  }
  const auto reached =
      std::count_if(configurations_.begin(), configurations_.end(),
                    [](const auto& configuration) { return configuration.second.state().reached; });
  return fmt::format("{} of {} configurations are narrow enough", reached, configurations_.size());
}

void RequireNoStop(const Sweep& sweep) {
  for (const Configuration& configuration : sweep.configurations) {
    const ScenarioSpec& spec = configuration.spec;
    CheckInput(spec.stop_width == 0,
               fmt::format("{} = {}: a shard does not have the scenes of the other shards, so it "
                           "cannot decide when to stop; run without shards, or set it to 0",
                           spec.At("stop_width"), spec.stop_width));
  }
}

}  // namespace pickbed::eval
