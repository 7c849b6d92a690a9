#include "eval/summary/cycle.h"

#include <algorithm>
#include <string>

namespace pickbed::eval {
namespace {

int ImagesOf(const TrialResult& trial) {
  return static_cast<int>(
      std::count_if(trial.attempts.begin(), trial.attempts.end(),
                    [](const AttemptRecord& attempt) { return attempt.has_own_image(); }));
}

// Returns the number of images that are captured while the arm moves outside the bin.
int OverlappingImagesOf(const TrialResult& trial) {
  int images = 0;
  bool moved = false;  // since the last image
  for (const AttemptRecord& attempt : trial.attempts) {
    if (attempt.has_own_image()) {
      images += moved;
      moved = false;
    }
    // The attempts of an occlusion trial are in separate scenes.
    moved = moved || (attempt.grasp && attempt.target < 0);
  }
  return images;
}

double MeasuredSeconds(const TrialResult& trial) {
  double measured_s = 0;
  for (const char* stage : {"estimate", "plan"}) {
    const auto seconds = trial.seconds.find(stage);
    if (seconds != trial.seconds.end()) measured_s += seconds->second;
  }
  return measured_s;
}

}  // namespace

CycleTime CycleTimeOf(std::span<const TrialResult> trials, const CycleSpec& spec) {
  CycleTime time;
  time.measured = spec.compute_s == 0;
  const double outside_s = spec.overlap ? std::max(0.0, spec.move_s - spec.in_bin_s) : 0;
  int all_images = 0, executed_grasps = 0, picked = 0;
  double measured_s = 0;
  const std::string* mounted = nullptr;  // tool of the last grasp
  for (const TrialResult& trial : trials) {
    const int images = ImagesOf(trial), overlapping = OverlappingImagesOf(trial);
    const double measured_of_trial_s = MeasuredSeconds(trial);
    all_images += images;
    picked += trial.instances_cleared;
    for (const AttemptRecord& attempt : trial.attempts) {
      executed_grasps += UsedHand(attempt);
      if (!attempt.grasp) continue;
      time.tool_changes += mounted != nullptr && *mounted != attempt.grasp->tool;
      mounted = &attempt.grasp->tool;
    }
    measured_s += measured_of_trial_s;
    if (images == 0) continue;
    const double compute_s = time.measured ? measured_of_trial_s / images : spec.compute_s;
    time.hidden_s += overlapping * std::min(spec.sense_s + compute_s, outside_s);
    time.stated_hidden_s += overlapping * std::min(spec.sense_s + spec.compute_s, outside_s);
  }
  if (picked == 0) {
    time.hidden_s = time.stated_hidden_s = 0;
    return time;
  }
  time.sense_s = spec.sense_s * all_images / picked;
  time.compute_s = (time.measured ? measured_s : spec.compute_s * all_images) / picked;
  time.move_s = (spec.move_s * executed_grasps + spec.tool_change_s * time.tool_changes) / picked;
  time.hidden_s /= picked;
  time.stated_hidden_s /= picked;
  return time;
}

}  // namespace pickbed::eval
