#include "eval/trial/pose_matching.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "eval/metrics/metric_table.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {
namespace {

// An instance in the camera frame with its distance to one hypothesis.
struct Candidate {
  int index = 0;  // into the scene
  double lower_bound_m = 0;
  double mssd_m = kInfinity;
};

// Lower bound of MSSD: the largest vertex displacement is at least the displacement of the mean
// vertex. Most instances never need the costly maximum over vertices and symmetries.
double MssdLowerBound(const MetricModel& model, const Eigen::Vector3d& mean_O, const Pose& X_est,
                      const Pose& X_true) {
  double best = kInfinity;
  const Eigen::Vector3d estimate = X_est * mean_O;
  for (const Pose& S : model.symmetries_O) {
    best = std::min(best, (estimate - X_true * (S * mean_O)).norm());
  }
  return best;
}

// Returns instances of the object with their MSSD, nearest first. The nearest instance and every
// instance within `needed_m` are among them.
std::vector<Candidate> NearInstances(const Scene& truth, const std::vector<Pose>& X_CO_true,
                                     const MetricModel& model, const PoseHypothesis& hypothesis,
                                     double needed_m) {
  const Eigen::Vector3d mean_O = MeanVertex(model);
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < truth.objects.size(); ++i) {
    if (truth.objects[i].object != hypothesis.object) continue;
    candidates.push_back(
        {static_cast<int>(i), MssdLowerBound(model, mean_O, hypothesis.X_CO, X_CO_true[i])});
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.lower_bound_m < b.lower_bound_m; });
  double best = kInfinity;
  size_t computed = 0;
  for (Candidate& candidate : candidates) {
    if (candidate.lower_bound_m > std::max(best, needed_m)) break;
    candidate.mssd_m = Mssd(model, hypothesis.X_CO, X_CO_true[candidate.index]);
    best = std::min(best, candidate.mssd_m);
    ++computed;
  }
  candidates.resize(computed);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.mssd_m < b.mssd_m; });
  return candidates;
}

HypothesisRecord Compare(const Scene& truth, const std::vector<Pose>& X_CO_true,
                         const MetricModel& model, const CameraIntrinsics& camera,
                         const PoseHypothesis& hypothesis, const std::vector<Candidate>& near) {
  HypothesisRecord score;
  score.object = hypothesis.object;
  score.score = hypothesis.score;
  if (near.empty()) {
    score.metrics = InfiniteMetrics();
    return score;
  }
  const Pose& X_CO = X_CO_true[near.front().index];
  score.instance = truth.objects[near.front().index].instance;
  score.metrics = RecordedMetrics(
      {model, camera, hypothesis.X_CO, X_CO, /*tolerance=*/nullptr, near.front().mssd_m});
  score.correct = score.mssd_diameters() < kCorrectDiameters;
  score.X_OE = X_CO.inverse() * hypothesis.X_CO;
  return score;
}

ObjectId NearestObject(const Scene& truth, const std::vector<Pose>& X_CO_true,
                       const std::vector<MetricModel>& models, const PoseHypothesis& hypothesis) {
  const Eigen::Vector3d estimated = hypothesis.X_CO * MeanVertex(models[hypothesis.object]);
  ObjectId nearest = kAnyObject;
  double least_m = kInfinity;
  for (size_t i = 0; i < truth.objects.size(); ++i) {
    const ObjectId object = truth.objects[i].object;
    const double distance_m = (X_CO_true[i] * MeanVertex(models[object]) - estimated).norm();
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    nearest = object;
  }
  return nearest;
}

}  // namespace

AttemptScore ScoreAgainstTruth(const Scene& truth, const std::vector<double>& visible_fractions,
                               const std::vector<MetricModel>& models, const Camera& camera,
                               const std::vector<PoseHypothesis>& hypotheses) {
  const Pose& X_CW = camera.X_CW();
  std::vector<Pose> X_CO_true;
  AttemptScore score;
  for (size_t i = 0; i < truth.objects.size(); ++i) {
    const PosedObject& posed = truth.objects[i];
    X_CO_true.push_back(X_CW * posed.X_WO);
    score.instances.push_back({posed.instance, posed.object, visible_fractions[i], false});
  }

  std::vector<int> order(hypotheses.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return hypotheses[a].score > hypotheses[b].score; });
  score.hypotheses.resize(hypotheses.size());
  score.taken.resize(hypotheses.size(), -1);
  for (int index : order) {
    const PoseHypothesis& hypothesis = hypotheses[index];
    const MetricModel& model = models[hypothesis.object];
    const double correct_m = kCorrectDiameters * model.diameter_m;
    const auto near = NearInstances(truth, X_CO_true, model, hypothesis, correct_m);
    score.hypotheses[index] = Compare(truth, X_CO_true, model, camera.intrinsics, hypothesis, near);
    score.hypotheses[index].X_WO = camera.X_WC() * hypothesis.X_CO;
    for (const Candidate& candidate : near) {
      if (candidate.mssd_m >= correct_m) break;
      InstanceRecord& record = score.instances[candidate.index];
      if (record.recalled) continue;
      record.recalled = true;
      score.taken[index] = candidate.index;
      break;
    }
  }
  for (const PoseHypothesis& hypothesis : hypotheses) {
    score.nearest_object.push_back(NearestObject(truth, X_CO_true, models, hypothesis));
  }
  return score;
}

}  // namespace pickbed::eval
