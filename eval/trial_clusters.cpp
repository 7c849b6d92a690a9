#include "eval/trial_clusters.h"

#include <algorithm>
#include <array>
#include <map>

namespace pickbed {
namespace {

constexpr double kStandsOnDiameters = 0.5;

bool InBand(double visible, double min, double max) {
  return visible >= min && (visible < max || max >= 1);
}

// Visible fraction of an instance in a look, -1 where it is not seen.
double VisibleFraction(const PickRecord& pick, int instance) {
  for (const InstanceRecord& record : pick.instances) {
    if (record.instance == instance) return record.visible_fraction;
  }
  return -1;
}

// Index in `scenes`, -1 = not among them.
int PlaceOf(int scene, const std::vector<int>& scenes) {
  const auto place = std::lower_bound(scenes.begin(), scenes.end(), scene);
  return place != scenes.end() && *place == scene ? static_cast<int>(place - scenes.begin()) : -1;
}

// Of an instance in a look: place of its scene, which trial of that scene, look, instance.
using Sighting = std::array<int, 4>;

std::map<Sighting, const HypothesisScore*> BestOfEach(std::span<const TrialResult> trials,
                                                      const std::vector<int>& scenes) {
  std::map<Sighting, const HypothesisScore*> best;
  std::vector<int> trials_of(scenes.size());
  for (const TrialResult& trial : trials) {
    const int place = PlaceOf(trial.scene, scenes);
    if (place < 0) continue;
    const int nth = trials_of[place]++;
    for (const PickRecord& look : trial.picks) {
      for (const HypothesisScore& pose : look.hypotheses) {
        if (pose.instance < 0 || !(pose.mssd_diameters < kStandsOnDiameters)) continue;
        if (look.target >= 0 && pose.instance != look.target) continue;
        const HypothesisScore*& chosen = best[{place, nth, look.pick, pose.instance}];
        if (chosen == nullptr || pose.score > chosen->score) chosen = &pose;
      }
    }
  }
  return best;
}

}  // namespace

std::vector<int> ScenesOf(std::span<const TrialResult> trials) {
  std::vector<int> scenes;
  for (const TrialResult& trial : trials) scenes.push_back(trial.scene);
  std::sort(scenes.begin(), scenes.end());
  scenes.erase(std::unique(scenes.begin(), scenes.end()), scenes.end());
  return scenes;
}

TrialCount SuccessOfAttempts() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const PickRecord& pick : trial.picks) {
      scene.tries += pick.grasp.has_value();
      scene.hits += pick.grasp && pick.loss == Loss::kNone;
    }
  };
}

TrialCount SuccessByRule(SuccessRule rule) {
  return [rule](const TrialResult& trial, Cluster& scene) {
    for (const PickRecord& pick : trial.picks) {
      scene.tries += pick.grasp.has_value();
      scene.hits += pick.grasp && pick.outcome.verdicts[static_cast<int>(rule)];
    }
  };
}

TrialCount PartsCleared() {
  return [](const TrialResult& trial, Cluster& scene) {
    scene.hits += trial.parts_cleared;
    scene.tries += trial.parts_dropped;
  };
}

TrialCount TopRankedRight() {
  return [](const TrialResult& trial, Cluster& scene) {
    for (const PickRecord& pick : trial.picks) {
      if (pick.hypotheses.empty()) continue;
      ++scene.tries;
      scene.hits += pick.hypotheses.front().correct;
    }
  };
}

TrialCount InstancesRecalled(double visible_min, double visible_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const PickRecord& pick : trial.picks) {
      for (const InstanceRecord& instance : pick.instances) {
        if (pick.target >= 0 && instance.instance != pick.target) continue;
        if (!InBand(instance.visible_fraction, visible_min, visible_max)) continue;
        ++scene.tries;
        scene.hits += instance.recalled;
      }
    }
  };
}

TrialCount SuccessByVisibility(double visible_min, double visible_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const PickRecord& pick : trial.picks) {
      if (!pick.grasp) continue;
      const int aim = pick.target >= 0 ? pick.target : pick.aimed;
      if (!InBand(VisibleFraction(pick, aim), visible_min, visible_max)) continue;
      ++scene.tries;
      scene.hits += pick.loss == Loss::kNone;
    }
  };
}

TrialCount TargetsPicked(double visible_min, double visible_max) {
  return [=](const TrialResult& trial, Cluster& scene) {
    for (const PickRecord& look : trial.picks) {
      if (look.target < 0) continue;
      if (!InBand(VisibleFraction(look, look.target), visible_min, visible_max)) continue;
      ++scene.tries;
      scene.hits += look.loss == Loss::kNone;
    }
  };
}

std::vector<Cluster> CountByScene(std::span<const TrialResult> trials,
                                  const std::vector<int>& scenes, const TrialCount& count) {
  std::vector<Cluster> clusters(scenes.size());
  for (const TrialResult& trial : trials) {
    const int place = PlaceOf(trial.scene, scenes);
    if (place >= 0) count(trial, clusters[place]);
  }
  return clusters;
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
    errors.before[sighting[0]].push_back(error(*pose));
    errors.after[sighting[0]].push_back(error(*same->second));
  }
  return errors;
}

}  // namespace pickbed
