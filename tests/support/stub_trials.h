#pragma once

// Made-up trials that hang together as those of a run do: parts that are the easier to find and
// pick the more of them is in view, confidences that are calibrated, losses of every kind, and
// scenes that are easier or harder as a whole. For tests and measurements of what is made of
// trials.

#include <algorithm>
#include <array>
#include <vector>

#include "eval/trial.h"
#include "scenes/random.h"

namespace pickbed {

struct StubOptions {
  int parts = 12;
  int looks = 5;
  double ease = 0;  // added to the probability that a pose is right
};

namespace stub {

inline HypothesisScore Hypothesis(const InstanceRecord& instance, double p_right, Rng& rng) {
  HypothesisScore score;
  score.object = instance.object;
  score.instance = instance.instance;
  score.score = p_right;
  score.correct = rng.Uniform() < p_right;
  score.mssd_diameters = (score.correct ? 0.0 : 0.1) + 0.09 * rng.Uniform();
  score.mssd_m = 0.08 * score.mssd_diameters;
  score.translation_m = 0.5 * score.mssd_m;
  score.rotation_rad = 2 * score.mssd_diameters;
  score.X_WO.translation() = 0.1 * rng.UnitVector();
  return score;
}

// The part with the surest pose, if there is one.
inline void Pick(PickRecord& look, Rng& rng) {
  static constexpr std::array kAfterRightPose{Loss::kSlipped, Loss::kDropped, Loss::kCollision,
                                              Loss::kTookTwo};
  if (look.hypotheses.empty()) {
    look.loss = Loss::kNoProposal;
    return;
  }
  if (rng.Uniform() < 0.05) {
    look.loss = Loss::kNoGrasp;
    return;
  }
  const HypothesisScore& chosen = look.hypotheses.front();
  look.chosen = 0;
  look.aimed = chosen.instance;
  look.grasp = Grasp();
  const bool held = rng.Uniform() < 0.92;
  look.loss = !chosen.correct ? Loss::kPoseWrong
              : held          ? Loss::kNone
                     : kAfterRightPose[rng.Index(static_cast<int>(kAfterRightPose.size()))];
  look.outcome.loss = look.loss;
  look.outcome.success = look.loss == Loss::kNone;
  look.outcome.picked_instance = look.loss == Loss::kNone ? look.aimed : -1;
}

}  // namespace stub

// The same for the same number.
inline TrialResult StubTrial(int trial, const StubOptions& options = {}) {
  Rng rng = Rng::Derive(17, trial, "stub");
  TrialResult result;
  result.trial = trial;
  result.parts_dropped = options.parts;
  const double scene_ease = options.ease + 0.3 * (rng.Uniform() - 0.5);
  std::vector<InstanceRecord> parts;
  for (int i = 0; i < options.parts; ++i) {
    InstanceRecord& part = parts.emplace_back();
    part.instance = i;
    part.object = i % 2;
    part.visible_fraction = rng.Uniform();
    result.fates.push_back({i, part.object, false, true, Loss::kNone, -1});
  }
  for (int p = 0; p < options.looks && !parts.empty(); ++p) {
    PickRecord& look = result.picks.emplace_back();
    look.pick = p;
    look.instances = parts;
    for (InstanceRecord& instance : look.instances) {
      const double p_right =
          std::clamp(0.35 + 0.6 * instance.visible_fraction + scene_ease, 0.02, 0.98);
      if (rng.Uniform() > 0.3 + 0.7 * instance.visible_fraction) continue;
      look.hypotheses.push_back(stub::Hypothesis(instance, p_right, rng));
      instance.recalled = look.hypotheses.back().correct;
    }
    std::stable_sort(look.hypotheses.begin(), look.hypotheses.end(),
                     [](auto& a, auto& b) { return a.score > b.score; });
    stub::Pick(look, rng);
    if (look.loss != Loss::kNone) continue;
    ++result.parts_cleared;
    result.fates[look.aimed].picked = true;
    result.fates[look.aimed].pick = p;
    std::erase_if(parts, [&](const InstanceRecord& part) { return part.instance == look.aimed; });
  }
  for (const InstanceRecord& part : parts) result.fates[part.instance].asked = false;
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

}  // namespace pickbed
