#include "perception/estimators/calibrated.h"

#include <utility>

#include "perception/estimators/finite_poses.h"

namespace pickbed::perception {
namespace {

class CalibratedEstimator : public PoseEstimator {
 public:
  CalibratedEstimator(std::unique_ptr<PoseEstimator> inner, ScoreCurve curve,
                      double min_probability)
      : inner_(std::move(inner)), curve_(std::move(curve)), min_probability_(min_probability) {}

  // The curve rises, so the order of the poses stays.
  EstimateResult Estimate(const EstimatorInput& input, Rng& rng) override {
    EstimateResult result = inner_->Estimate(input, rng);
    DropNotFinite(result.hypotheses);
    for (PoseHypothesis& hypothesis : result.hypotheses) {
      hypothesis.raw_score = hypothesis.score;
      hypothesis.score = curve_.At(hypothesis.score);
    }
    std::erase_if(result.hypotheses,
                  [this](const PoseHypothesis& h) { return h.score < min_probability_; });
    return result;
  }

 private:
  std::unique_ptr<PoseEstimator> inner_;
  ScoreCurve curve_;
  double min_probability_;
};

class RankedEstimator : public PoseEstimator {
 public:
  explicit RankedEstimator(std::unique_ptr<PoseEstimator> inner) : inner_(std::move(inner)) {}

  EstimateResult Estimate(const EstimatorInput& input, Rng& rng) override {
    EstimateResult result = inner_->Estimate(input, rng);
    DropNotFinite(result.hypotheses);
    const double count = static_cast<double>(result.hypotheses.size());
    for (size_t i = 0; i < result.hypotheses.size(); ++i) {
      PoseHypothesis& hypothesis = result.hypotheses[i];
      hypothesis.raw_score = hypothesis.score;
      hypothesis.score = 1 - static_cast<double>(i) / count;
    }
    return result;
  }

 private:
  std::unique_ptr<PoseEstimator> inner_;
};

}  // namespace

std::unique_ptr<PoseEstimator> MakeCalibrated(std::unique_ptr<PoseEstimator> inner,
                                              ScoreCurve curve, double min_probability) {
  return std::make_unique<CalibratedEstimator>(std::move(inner), std::move(curve), min_probability);
}

std::unique_ptr<PoseEstimator> MakeRanked(std::unique_ptr<PoseEstimator> inner) {
  return std::make_unique<RankedEstimator>(std::move(inner));
}

}  // namespace pickbed::perception
