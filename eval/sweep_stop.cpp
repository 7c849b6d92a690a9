#include "eval/sweep_stop.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/sweep.h"
#include "eval/trial_clusters.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

Cluster OutcomeOf(const TrialResult& trial) {
  Cluster outcome;
  SuccessOfAttempts()(trial, outcome);
  return outcome;
}

}  // namespace

void PointStop::Add(int scene, const Cluster& outcome) {
  later_.emplace(scene, outcome);
  for (auto next = later_.find(scenes_); next != later_.end() && !stop_.Reached();
       next = later_.find(scenes_)) {
    stop_.Add(next->second);
    later_.erase(next);
    ++scenes_;
  }
}

StopState PointStop::state() const {
  return {width_, scenes_, stop_.mean(), stop_.interval(), stop_.Reached()};
}

std::optional<StopState> StopOf(const std::vector<TrialResult>& trials,
                                const std::vector<int>& crashed_scenes, double width) {
  if (width == 0) return std::nullopt;
  PointStop stop(width);
  for (const int scene : crashed_scenes) stop.Add(scene, {});
  for (const TrialResult& trial : trials) stop.Add(trial.scene, OutcomeOf(trial));
  return stop.state();
}

SweepStop::SweepStop(const Sweep& sweep) : sweep_(sweep) {
  for (const SweepPoint& point : sweep.points) {
    const double width = point.spec.stop_width;
    if (width > 0) points_.emplace(point.point, PointStop(width));
  }
}

void SweepStop::Add(const TrialResult& result) {
  const auto point = points_.find(result.point);
  if (point != points_.end()) point->second.Add(result.scene, OutcomeOf(result));
}

bool SweepStop::Add(int trial, const Cluster& outcome) {
  const SweepPoint& owner = PointOf(sweep_, trial);
  const auto point = points_.find(owner.point);
  if (point == points_.end() || point->second.state().reached) return false;
  point->second.Add(trial - owner.first_trial, outcome);
  return point->second.state().reached;
}

bool SweepStop::Counts(int trial) const {
  const SweepPoint& owner = PointOf(sweep_, trial);
  const auto point = points_.find(owner.point);
  return point == points_.end() || point->second.Counts(trial - owner.first_trial);
}

std::string SweepStop::Note() const {
  if (!enabled()) return "";
  if (points_.size() == 1) {
    const StopState state = points_.begin()->second.state();
    const double width = state.interval.high - state.interval.low;
    return fmt::format("{:.3f} wide, stops at {:.3f}", width, state.width);
  }
  const auto reached = std::count_if(points_.begin(), points_.end(), [](const auto& point) {
    return point.second.state().reached;
  });
  return fmt::format("{} of {} points are narrow enough", reached, points_.size());
}

void RequireNoStop(const Sweep& sweep) {
  for (const SweepPoint& point : sweep.points) {
    const ScenarioSpec& spec = point.spec;
    CheckInput(spec.stop_width == 0,
               fmt::format("{} = {}: a shard sees no other's scenes, so that none can tell when to "
                           "stop; leave out the shards, or set it to 0",
                           spec.At("stop_width"), spec.stop_width));
  }
}

std::string StopText(const StopState& state) {
  const std::string interval = fmt::format("{:.3f} in [{:.3f}, {:.3f}]", state.mean,
                                           state.interval.low, state.interval.high);
  if (!state.reached) {
    return fmt::format("not yet narrow enough after {} bins: {}, to be no wider than {:.3f}",
                       state.scenes, interval, state.width);
  }
  return fmt::format("stops after {} bins: {}, no wider than {:.3f}", state.scenes, interval,
                     state.width);
}

}  // namespace pickbed
