#include "eval/cycle.h"

namespace pickbed {

CycleTime CycleTimeOf(std::span<const TrialResult> trials, const CycleSpec& spec) {
  CycleTime time;
  time.measured = spec.compute_s == 0;
  int looks = 0, attempts = 0, picked = 0;
  double measured_s = 0;
  for (const TrialResult& trial : trials) {
    looks += static_cast<int>(trial.picks.size());
    picked += trial.parts_cleared;
    for (const PickRecord& pick : trial.picks) attempts += pick.grasp.has_value();
    for (const char* stage : {"estimate", "plan"}) {
      const auto seconds = trial.seconds.find(stage);
      if (seconds != trial.seconds.end()) measured_s += seconds->second;
    }
  }
  if (picked == 0) return time;
  time.sense_s = spec.sense_s * looks / picked;
  time.compute_s = (time.measured ? measured_s : spec.compute_s * looks) / picked;
  time.move_s = spec.move_s * attempts / picked;
  return time;
}

}  // namespace pickbed
