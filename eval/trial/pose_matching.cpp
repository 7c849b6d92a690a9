#include "eval/trial/pose_matching.h"

#include <algorithm>
#include <numeric>

#include "eval/metrics/metric_table.h"

namespace pickbed::eval {
namespace {

HypothesisRecord Compare(const InstanceMatcher& truth, const Camera& camera,
                         const Pose& calibrated_X_WC, const PoseHypothesis& hypothesis,
                         const std::vector<InstanceMatch>& matches) {
  HypothesisRecord score;
  score.object = hypothesis.object;
  score.score = hypothesis.score;
  score.raw_score = hypothesis.raw_score.value_or(hypothesis.score);
  score.X_WO = calibrated_X_WC * hypothesis.X_CO;
  if (matches.empty()) {
    score.metrics = InfiniteMetrics();
    return score;
  }
  const TrueInstance& nearest = truth.instances()[matches.front().position];
  score.instance = nearest.instance;
  score.metrics =
      RecordedMetrics({truth.model(hypothesis.object), camera.intrinsics, hypothesis.X_CO,
                       nearest.X_CO, /*tolerance=*/nullptr, matches.front().mssd_m});
  score.correct = score.mssd_diameters() < kCorrectDiameters;
  const bool exact = calibrated_X_WC.matrix() == camera.X_WC().matrix();
  const Pose X_CE = exact ? hypothesis.X_CO : camera.X_CW() * calibrated_X_WC * hypothesis.X_CO;
  score.X_OE = nearest.X_CO.inverse() * X_CE;
  return score;
}

}  // namespace

std::vector<HypothesisRecord> AttemptScore::Records() const {
  std::vector<HypothesisRecord> records;
  for (const ScoredHypothesis& hypothesis : hypotheses) records.push_back(hypothesis.record);
  return records;
}

AttemptScore ScoreAgainstTruth(const InstanceMatcher& truth, const Camera& camera,
                               const std::vector<PoseHypothesis>& hypotheses) {
  return ScoreAgainstTruth(truth, camera, camera.X_WC(), hypotheses);
}

AttemptScore ScoreAgainstTruth(const InstanceMatcher& truth, const Camera& camera,
                               const Pose& calibrated_X_WC,
                               const std::vector<PoseHypothesis>& hypotheses) {
  AttemptScore score;
  for (const TrueInstance& instance : truth.instances()) {
    score.instances.push_back(
        {instance.instance, instance.object, instance.visible_fraction, false});
  }
  std::vector<int> order(hypotheses.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return hypotheses[a].score > hypotheses[b].score; });
  std::vector<bool> taken(truth.instances().size(), false);
  score.hypotheses.resize(hypotheses.size());
  for (const int index : order) {
    const PoseHypothesis& hypothesis = hypotheses[index];
    const auto matches = truth.ByDistance(hypothesis.object, hypothesis.X_CO);
    const int recalled = FirstFreeCorrect(matches, taken);
    if (recalled >= 0) taken[recalled] = score.instances[recalled].recalled = true;
    score.hypotheses[index] = {
        hypothesis, Compare(truth, camera, calibrated_X_WC, hypothesis, matches), recalled,
        truth.NearestOfAnyObject(hypothesis.object, hypothesis.X_CO)};
  }
  return score;
}

}  // namespace pickbed::eval
