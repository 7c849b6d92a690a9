#include "eval/trial/counts_by_bin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/stage_oracle.h"

namespace pickbed::eval {
namespace {

bool InBand(double visible, double min, double max) {
  return visible >= min && (visible < max || max >= 1);
}

// Visible fraction of an instance in an attempt, -1 if the attempt has no record of it.
double VisibleFraction(const AttemptRecord& attempt, InstanceId instance) {
  for (const InstanceRecord& record : attempt.instances) {
    if (record.instance == instance) return record.visible_fraction;
  }
  return -1;
}

// Index in `scenes`, -1 = not among them.
int PlaceOf(int scene, const std::vector<int>& scenes) {
  const auto place = std::lower_bound(scenes.begin(), scenes.end(), scene);
  return place != scenes.end() && *place == scene ? static_cast<int>(place - scenes.begin()) : -1;
}

// Key of an instance in an attempt: index of its bin, number of the trial of this bin, attempt,
// instance.
using Sighting = std::array<int, 4>;

std::map<Sighting, const HypothesisRecord*> BestOfEach(std::span<const TrialResult> trials,
                                                       const std::vector<int>& scenes) {
  std::map<Sighting, const HypothesisRecord*> best;
  std::vector<int> trials_of(scenes.size());
  for (const TrialResult& trial : trials) {
    const int place = PlaceOf(trial.bin_index, scenes);
    if (place < 0) continue;
    const int nth = trials_of[place]++;
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.has_own_image()) continue;
      for (const HypothesisRecord& pose : attempt.hypotheses) {
        if (pose.instance < 0 || !(pose.mssd_diameters() < kMatchDiameters)) continue;
        if (attempt.target >= 0 && pose.instance != attempt.target) continue;
        const HypothesisRecord*& chosen = best[{place, nth, attempt.attempt, pose.instance}];
        if (chosen == nullptr || pose.score > chosen->score) chosen = &pose;
      }
    }
  }
  return best;
}

}  // namespace

std::vector<int> ScenesOf(std::span<const TrialResult> trials) {
  std::vector<int> scenes;
  for (const TrialResult& trial : trials) scenes.push_back(trial.bin_index);
  std::sort(scenes.begin(), scenes.end());
  scenes.erase(std::unique(scenes.begin(), scenes.end()), scenes.end());
  return scenes;
}

TrialCount SuccessOfAttempts() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      scene.samples += UsedHand(attempt);
      scene.hits += attempt.grasp && attempt.failure == FailureReason::kNone;
    }
  };
}

TrialCount SuccessByRule(SuccessRule rule) {
  return [rule](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      scene.samples += UsedHand(attempt);
      scene.hits += attempt.grasp && attempt.outcome.verdicts[static_cast<int>(rule)];
    }
  };
}

TrialCount AttemptsThatPicked() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      ++scene.samples;
      scene.hits += attempt.grasp && attempt.failure == FailureReason::kNone;
    }
  };
}

TrialCount RequestedCleared() {
  return [](const TrialResult& trial, Cluster& scene) {
    const auto asked = std::count_if(trial.outcomes.begin(), trial.outcomes.end(),
                                     [](const InstanceOutcome& outcome) { return outcome.asked; });
    scene.hits += trial.instances_cleared;
    scene.samples += trial.outcomes.empty() ? trial.instances_dropped : static_cast<int>(asked);
  };
}

TrialCount AllInstancesRecalled() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.has_own_image() || attempt.pose_free) continue;
      for (const InstanceRecord& instance : attempt.instances) {
        if (instance.visible_fraction < kCountedVisibility) continue;
        ++scene.samples;
        scene.hits += instance.recalled;
      }
    }
  };
}

TrialCount PosesRight() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.has_own_image()) continue;
      scene.samples += static_cast<int>(attempt.hypotheses.size());
      for (const InstanceRecord& instance : attempt.instances) scene.hits += instance.recalled;
    }
  };
}

TrialCount InstancesCleared() {
  return [](const TrialResult& trial, Cluster& scene) {
    scene.hits += trial.instances_cleared;
    scene.samples += trial.instances_dropped;
  };
}

TrialCount TopRankedRight() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.has_own_image()) continue;
      if (attempt.hypotheses.empty()) continue;
      ++scene.samples;
      scene.hits += attempt.hypotheses.front().correct;
    }
  };
}

TrialCount InstancesRecalled(double visible_min, double visible_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.has_own_image() || attempt.pose_free) continue;
      for (const InstanceRecord& instance : attempt.instances) {
        if (attempt.target >= 0 && instance.instance != attempt.target) continue;
        if (!InBand(instance.visible_fraction, visible_min, visible_max)) continue;
        ++scene.samples;
        scene.hits += instance.recalled;
      }
    }
  };
}

TrialCount SuccessByVisibility(double visible_min, double visible_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.grasp) continue;
      const InstanceId target = attempt.target >= 0 ? attempt.target : attempt.matched_instance;
      if (!InBand(VisibleFraction(attempt, target), visible_min, visible_max)) continue;
      ++scene.samples;
      scene.hits += attempt.failure == FailureReason::kNone;
    }
  };
}

TrialCount SuccessByFill(double fill_min, double fill_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.grasp || attempt.fill_level < fill_min || attempt.fill_level >= fill_max)
        continue;
      ++scene.samples;
      scene.hits += attempt.failure == FailureReason::kNone;
    }
  };
}

TrialCount SuccessByLayer(int first_layer, int last_layer) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.grasp || attempt.layer < first_layer || attempt.layer > last_layer) continue;
      ++scene.samples;
      scene.hits += attempt.failure == FailureReason::kNone;
    }
  };
}

TrialCount TargetsPicked(double visible_min, double visible_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.target < 0) continue;
      if (!InBand(VisibleFraction(attempt, attempt.target), visible_min, visible_max)) continue;
      ++scene.samples;
      scene.hits += attempt.failure == FailureReason::kNone;
    }
  };
}

std::vector<Cluster> CountByScene(std::span<const TrialResult> trials,
                                  const std::vector<int>& scenes, const TrialCount& count) {
  std::vector<Cluster> clusters(scenes.size());
  for (const TrialResult& trial : trials) {
    const int place = PlaceOf(trial.bin_index, scenes);
    if (place >= 0) count(trial, clusters[place]);
  }
  return clusters;
}

bool HasTargets(std::span<const TrialResult> trials) {
  return std::any_of(trials.begin(), trials.end(), [](const TrialResult& trial) {
    return std::any_of(trial.attempts.begin(), trial.attempts.end(),
                       [](const AttemptRecord& attempt) { return attempt.target >= 0; });
  });
}

std::vector<Cluster> CountByScene(std::span<const TrialResult> trials, const TrialCount& count) {
  return CountByScene(trials, ScenesOf(trials), count);
}

PairedErrors PairedErrorsByScene(std::span<const TrialResult> before,
                                 std::span<const TrialResult> after, const std::vector<int>& scenes,
                                 const ErrorOfPose& error) {
  PairedErrors errors{ValueClusters(scenes.size()), ValueClusters(scenes.size())};
  const auto best_after = BestOfEach(after, scenes);
  for (const auto& [sighting, pose] : BestOfEach(before, scenes)) {
    const auto same = best_after.find(sighting);
    if (same == best_after.end()) continue;
    const double error_before = error(*pose), error_after = error(*same->second);
    if (!std::isfinite(error_before) || !std::isfinite(error_after)) continue;
    errors.before[sighting[0]].push_back(error_before);
    errors.after[sighting[0]].push_back(error_after);
  }
  return errors;
}

}  // namespace pickbed::eval
