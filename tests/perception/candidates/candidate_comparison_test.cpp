#include "perception/candidates/candidate_comparison.h"

#include <gtest/gtest.h>

#include <numbers>

#include "perception/verify/depth_evidence.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

class ComparedCandidates : public testing::Test {
 protected:
  static Candidate At(const Pose& X_CO, double evidence) {
    Candidate candidate;
    candidate.hypothesis.X_CO = X_CO;
    candidate.features = {};
    candidate.features[kAgreeingFeature] = 0.5f;
    candidate.evidence = evidence;
    return candidate;
  }

  const std::shared_ptr<const ObjectModel> object_ = ObjectOf(BracketMesh());
  const std::vector<ModelPoints> models_{MakeModelPoints(*object_)};
  const PoseDistance distance_{*object_};
  const Pose X_CO_ = Translation({0, 0, 0.5});
  const Pose far_ = Translation({3 * object_->diameter_m, 0, 0.5});
};

TEST_F(ComparedCandidates, EvidentCandidatesAreTheBestFittingOfEachPlace) {
  const Pose near = Translation({0.1 * object_->diameter_m, 0, 0}) * X_CO_;
  std::vector<Candidate> candidates{At(X_CO_, 10), At(near, 20), At(far_, 5)};
  const auto evident = EvidentCandidates(candidates, models_);
  EXPECT_EQ(evident, (std::vector<const Candidate*>{&candidates[1], &candidates[2]}));
  candidates[1].features[kViolatedFeature] = 0.1f;  // a fifth of the agreeing share
  candidates[2].features[kAgreeingFeature] = 0.2f;  // only a small share agrees
  EXPECT_EQ(EvidentCandidates(candidates, models_),
            (std::vector<const Candidate*>{&candidates[0]}));
}

TEST_F(ComparedCandidates, MarginComparesWithOtherPosesAtTheSamePlace) {
  const Pose rotated =
      X_CO_ * Pose(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  const Pose nearly = X_CO_ * Pose(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()));
  std::vector<Candidate> candidates{At(X_CO_, 300), At(rotated, 200), At(nearly, 400), At(far_, 1)};
  std::vector<Candidate*> all;
  for (Candidate& candidate : candidates) all.push_back(&candidate);
  FillMargins(distance_, models_[0], all);
  const float ahead = EvidenceMargin(300, 200);
  EXPECT_GT(ahead, 0);
  EXPECT_EQ(candidates[0].features[kMarginFeature], ahead);
  EXPECT_EQ(candidates[1].features[kMarginFeature], EvidenceMargin(200, 400));
  EXPECT_EQ(candidates[3].features[kMarginFeature], 1) << "it has no rival";
}

TEST_F(ComparedCandidates, OverlapExcludesCandidatesAtTheSamePlace) {
  const Candidate evident = At(X_CO_, 10);
  const Pose beside = Translation({0.3 * object_->diameter_m, 0, 0}) * X_CO_;
  EXPECT_GT(OverlapWith({&evident}, At(beside, 1), models_), 0.01);
  EXPECT_EQ(OverlapWith({&evident}, At(X_CO_, 1), models_), 0);
  EXPECT_EQ(OverlapWith({&evident}, At(far_, 1), models_), 0);
}

// A plausible but wrong pose of another object must not lower a right pose that explains more.
TEST_F(ComparedCandidates, OverlapWithOtherObjectsNeedsMoreEvidence) {
  const std::vector<ModelPoints> two{models_[0], models_[0]};
  const auto of_other = [&](const Pose& X_CO, double evidence) {
    Candidate candidate = At(X_CO, evidence);
    candidate.hypothesis.object = ObjectId{1};
    return candidate;
  };
  const Pose beside = Translation({0.3 * object_->diameter_m, 0, 0}) * X_CO_;
  const Candidate strong = of_other(far_, 30), weak = of_other(X_CO_, 10), same = At(X_CO_, 10);
  const double deep = OverlapWith({&same}, At(beside, 20), two);
  EXPECT_GT(deep, 0.01);
  EXPECT_EQ(OverlapWith({&weak}, At(beside, 7), two), deep);
  EXPECT_EQ(OverlapWith({&weak}, At(beside, 20), two), 0);
  EXPECT_EQ(OverlapWith({&strong, &weak}, At(beside, 7), two), deep);
  EXPECT_EQ(OverlapWith({&strong, &weak}, At(beside, 20), two), 0);
}

}  // namespace
}  // namespace pickbed::tests
