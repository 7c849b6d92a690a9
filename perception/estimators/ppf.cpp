#include "perception/estimators/ppf.h"

#include <algorithm>

#include "perception/estimators/ppf_verified.h"
#include "perception/icp/final_refinement.h"
#include "perception/verify/non_maximum_suppression.h"
#include "perception/verify/pose_features.h"

namespace pickbed::perception {
namespace {

// Returns the inlier share minus the violated share, relative to the share that is not hidden. The
// score is lowered if there are few inliers.
double ScoreOf(const FitReport& fit, double full_support) {
  const double expected = 1 - fit.hidden_share;
  if (expected <= 0) return 0;
  const double agreement = (fit.inlier_share - fit.violated_share) / expected;
  return std::clamp(agreement * std::min(1.0, fit.inlier_share / full_support), 0.0, 1.0);
}

template <typename Work>
auto Timed(StageSeconds& seconds, const char* stage, Work work) {
  const StageTimer timer(seconds, stage);
  return work();
}

class PpfEstimator : public PoseEstimator {
 public:
  PpfEstimator(const EstimatorSetup& setup, const PpfOptions& options)
      : options_(options),
        min_score_(setup.spec.min_score),
        refiner_(setup.refiner),
        threads_(setup.threads) {
    for (const auto& object : setup.objects) {
      models_.push_back(MakeModelPoints(*object));
      matchers_.push_back(std::make_unique<PpfMatcher>(models_.back(), options_.match));
    }
  }

  EstimateResult Estimate(const EstimatorInput& input, Rng&) override {
    EstimateResult result;
    const OrganizedCloud cloud = Timed(result.seconds, "cloud", [&] {
      return BuildCloud(input.frame, input.background, {}, input.region, threads_);
    });
    result.has_background = input.background.has_value() || !cloud.planes.empty();
    std::vector<PoseHypothesis> found;
    for (size_t object = 0; object < models_.size(); ++object) {
      const PpfMatcher& matcher = *matchers_[object];
      const std::vector<float> scene = matcher.SceneRows(cloud);
      std::vector<Pose> poses =
          Timed(result.seconds, "match", [&] { return matcher.Match(scene); });
      if (static_cast<int>(poses.size()) > options_.max_poses) poses.resize(options_.max_poses);
      poses =
          Timed(result.seconds, "icp", [&] { return matcher.Refine(scene, poses, options_.icp); });
      Timed(result.seconds, "verify", [&] { Score(ObjectId(object), cloud, poses, found); });
    }
    result.hypotheses = Timed(result.seconds, "non_maximum_suppression", [&] {
      return SuppressNonMaxima(cloud, models_, std::move(found), {}, input.instances);
    });
    Timed(result.seconds, "refine",
          [&] { RefineFinally(refiner_, cloud, models_, threads_, result.hypotheses); });
    return result;
  }

 private:
  // Appends the poses that reach the minimum score.
  void Score(ObjectId object, const OrganizedCloud& cloud, const std::vector<Pose>& poses,
             std::vector<PoseHypothesis>& found) const {
    for (const Pose& X_CO : poses) {
      if (!X_CO.matrix().allFinite()) continue;
      PoseHypothesis h;
      h.object = object;
      h.X_CO = X_CO;
      h.fit = MeasureFit(cloud, models_[object], X_CO);
      h.score = ScoreOf(h.fit, options_.full_support);
      if (h.score >= min_score_) found.push_back(h);
    }
  }

  PpfOptions options_;
  double min_score_;
  std::string refiner_;
  int threads_;
  std::vector<ModelPoints> models_;
  std::vector<std::unique_ptr<PpfMatcher>> matchers_;
};

}  // namespace

void PpfOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "match", [this](SettingsVisitor& g) { match.Visit(g); }, "matching of point pairs");
  v.Group(
      "icp", [this](SettingsVisitor& g) { icp.Visit(g); }, "refinement of the matches");
  v.Integer("max_poses", max_poses, {1, 1000000}, "maximum number of refined poses per object");
  v.Real("full_support", full_support, {0, 1}, "inlier share below which the score is lowered");
}

std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup,
                                                const PpfOptions& options) {
  CheckSettings("PpfOptions", options);
  return std::make_unique<PpfEstimator>(setup, options);
}

std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup) {
  if (setup.spec.mode == kVerifiedMode) return MakeVerifiedPpfEstimator(setup, {});
  return MakePpfEstimator(setup, PpfOptions{});
}

}  // namespace pickbed::perception
