#include "eval/summary/cycle.h"

#include <string>

namespace pickbed::eval {

CycleTime CycleTimeOf(std::span<const TrialResult> trials, const CycleSpec& spec) {
  CycleTime time;
  time.measured = spec.compute_s == 0;
  int attempts = 0, executed_grasps = 0, picked = 0;
  double measured_s = 0;
  const std::string* mounted = nullptr;  // tool of the last grasp
  for (const TrialResult& trial : trials) {
    attempts += static_cast<int>(trial.attempts.size());
    picked += trial.instances_cleared;
    for (const AttemptRecord& attempt : trial.attempts) {
      executed_grasps += UsedHand(attempt);
      if (!attempt.grasp) continue;
      time.tool_changes += mounted != nullptr && *mounted != attempt.grasp->tool;
      mounted = &attempt.grasp->tool;
    }
    for (const char* stage : {"estimate", "plan"}) {
      const auto seconds = trial.seconds.find(stage);
      if (seconds != trial.seconds.end()) measured_s += seconds->second;
    }
  }
  if (picked == 0) return time;
  time.sense_s = spec.sense_s * attempts / picked;
  time.compute_s = (time.measured ? measured_s : spec.compute_s * attempts) / picked;
  time.move_s = (spec.move_s * executed_grasps + spec.tool_change_s * time.tool_changes) / picked;
  return time;
}

}  // namespace pickbed::eval
