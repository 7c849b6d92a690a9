#pragma once

// Stub trials with the correlations of a real run, for tests and measurements of code that
// processes trials. Instances with a larger visible fraction are easier to find and to pick,
// confidences are calibrated, all kinds of failures occur, and whole scenes are easier or harder.

#include <algorithm>
#include <array>
#include <vector>

#include "eval/trial/trial.h"
#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

struct StubOptions {
  int instances = 12;
  int attempts = 5;
  double ease = 0;  // added to the probability that a pose is correct
};

namespace stub {

inline HypothesisRecord Hypothesis(const InstanceRecord& instance, double p_right, Rng& rng) {
  HypothesisRecord score;
  score.object = instance.object;
  score.instance = instance.instance;
  score.score = p_right;
  score.correct = rng.Uniform() < p_right;
  score.metrics.Set(kMssdDiameters, (score.correct ? 0.0 : 0.1) + 0.09 * rng.Uniform());
  score.metrics.Set(kMssd_m, 0.08 * score.mssd_diameters());
  score.metrics.Set(kTranslation_m, 0.5 * score.mssd_m());
  score.metrics.Set(kRotation_rad, 2 * score.mssd_diameters());
  score.X_WO.translation() = 0.1 * rng.UnitVector();
  return score;
}

// Simulates the pick of the instance with the most confident pose, if there is one.
inline void Pick(AttemptRecord& attempt, Rng& rng) {
  static constexpr std::array kAfterRightPose{FailureReason::kSlipped, FailureReason::kDropped,
                                              FailureReason::kCollision,
                                              FailureReason::kDoublePick};
  if (attempt.hypotheses.empty()) {
    attempt.failure = FailureReason::kNoProposal;
    return;
  }
  if (rng.Uniform() < 0.05) {
    attempt.failure = FailureReason::kNoGrasp;
    return;
  }
  const HypothesisRecord& chosen = attempt.hypotheses.front();
  attempt.chosen = 0;
  attempt.matched_instance = chosen.instance;
  attempt.grasp = Grasp();
  const bool held = rng.Uniform() < 0.92;
  attempt.failure = !chosen.correct ? FailureReason::kPoseWrong
                    : held          ? FailureReason::kNone
                           : kAfterRightPose[rng.Index(static_cast<int>(kAfterRightPose.size()))];
  attempt.outcome.failure = attempt.failure;
  attempt.outcome.success = attempt.failure == FailureReason::kNone;
  attempt.outcome.picked_instance =
      attempt.failure == FailureReason::kNone ? attempt.matched_instance : kNoInstance;
}

}  // namespace stub

// Returns a stub trial that depends only on its number and the options.
inline TrialResult StubTrial(int trial, const StubOptions& options = {}) {
  Rng rng = Rng::Derive(17, trial, "stub");
  TrialResult result;
  result.trial = trial;
  result.instances_dropped = options.instances;
  const double scene_ease = options.ease + 0.3 * (rng.Uniform() - 0.5);
  std::vector<InstanceRecord> instances;
  for (int i = 0; i < options.instances; ++i) {
    InstanceRecord& instance = instances.emplace_back();
    instance.instance = InstanceId(i);
    instance.object = ObjectId(i % 2);
    instance.visible_fraction = rng.Uniform();
    result.outcomes.push_back(
        {instance.instance, instance.object, false, true, FailureReason::kNone, -1});
  }
  for (int p = 0; p < options.attempts && !instances.empty(); ++p) {
    AttemptRecord& attempt = result.attempts.emplace_back();
    attempt.attempt = p;
    attempt.instances = instances;
    attempt.fill_level = 0.6 * static_cast<double>(instances.size()) / options.instances;
    for (InstanceRecord& instance : attempt.instances) {
      const double p_right =
          std::clamp(0.35 + 0.6 * instance.visible_fraction + scene_ease, 0.02, 0.98);
      if (rng.Uniform() > 0.3 + 0.7 * instance.visible_fraction) continue;
      attempt.hypotheses.push_back(stub::Hypothesis(instance, p_right, rng));
      instance.recalled = attempt.hypotheses.back().correct;
    }
    std::stable_sort(attempt.hypotheses.begin(), attempt.hypotheses.end(),
                     [](auto& a, auto& b) { return a.score > b.score; });
    stub::Pick(attempt, rng);
    if (attempt.failure != FailureReason::kNone) continue;
    ++result.instances_cleared;
    result.outcomes[attempt.matched_instance].picked = true;
    result.outcomes[attempt.matched_instance].attempt = p;
    std::erase_if(instances, [&](const InstanceRecord& instance) {
      return instance.instance == attempt.matched_instance;
    });
  }
  for (const InstanceRecord& instance : instances) result.outcomes[instance.instance].asked = false;
  result.seconds = {{"drop", 0.2 + 0.1 * rng.Uniform()},
                    {"estimate", 2 + rng.Uniform()},
                    {"estimate/icp", 1 + 0.5 * rng.Uniform()},
                    {"execute", 0.5 * rng.Uniform()}};
  return result;
}

inline std::vector<TrialResult> StubTrials(int count, const StubOptions& options = {}) {
  std::vector<TrialResult> trials;
  for (int i = 0; i < count; ++i) trials.push_back(StubTrial(i, options));
  return trials;
}

}  // namespace pickbed::tests
