#include "perception/candidates/pose_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/verify/image_domain.h"
#include "scenes/base/finite_counts.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A verifier whose score increases with feature 0 only: 0.5 at 0.
Verifier ByFirstFeature() {
  Verifier v;
  v.known.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  v.known.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  v.known.w1 = Eigen::MatrixXf::Zero(1, kVerifyFeatures);
  v.known.w1(0, 0) = 1;
  v.known.b1 = Eigen::VectorXf::Zero(1);
  v.known.w2 = Eigen::VectorXf::Constant(1, 4);
  v.unknown = v.known;
  return v;
}

// One bracket is visible. The candidates are on it or where there is nothing.
class SelectedPosesOfABracket : public ::testing::Test {
 protected:
  SelectedPosesOfABracket() {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, BracketPose());
    cloud_ = BuildCloud(scene.frame(), std::nullopt, CloudOptions{.min_plane_share = 1});
  }
  static Candidate At(const Pose& X_CO, float feature) {
    Candidate candidate;
    candidate.hypothesis.X_CO = X_CO;
    candidate.features[0] = feature;
    return candidate;
  }
  std::vector<PoseHypothesis> Select(const std::vector<Candidate>& candidates,
                                     double min_score) const {
    PoseSelectionOptions options;
    options.min_score = min_score;
    return SelectPoses(cloud_, models_, distances_, verifiers_, candidates, options);
  }

  std::shared_ptr<const ObjectModel> object_ = ObjectOf(BracketMesh());
  std::vector<ModelPoints> models_{MakeModelPoints(*object_)};
  std::vector<PoseDistance> distances_{PoseDistance(*object_)};
  std::vector<Verifier> verifiers_{ByFirstFeature()};
  OrganizedCloud cloud_;
};

TEST_F(SelectedPosesOfABracket, ScoreIsFromTheVerifierAndMinScoreApplies) {
  const Candidate candidate = At(BracketPose(), 0.2f);
  const auto kept = Select({candidate}, 0.5);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].score, ByFirstFeature().Score(candidate.features));
  EXPECT_GT(kept[0].score, 0.6);
  EXPECT_TRUE(Select({At(BracketPose(), -0.1f)}, 0.5).empty());
}

TEST_F(SelectedPosesOfABracket, ScoresThatAreNotFiniteAreDroppedAndCounted) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  TakeNotFiniteCounts();
  const auto kept = Select({At(BracketPose(), kNaN), At(BracketPose(), 0.2f)}, 0);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_TRUE(std::isfinite(kept[0].score));
  EXPECT_EQ(TakeNotFiniteCounts(), (StageSeconds{{"not_finite/scores", 1}}));
}

TEST_F(SelectedPosesOfABracket, ScoreUsesTheRequestedMode) {
  for (auto& modes : verifiers_[0].calibrations) modes[1] = {1, -3};
  PoseSelectionOptions options;
  options.mode = CandidateMode::kFast;
  options.min_score = 0;
  const Candidate candidate = At(BracketPose(), 0.2f);
  const auto kept = SelectPoses(cloud_, models_, distances_, verifiers_, {candidate}, options);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_LT(kept[0].score, 0.3) << "it is 0.69 in mode accurate";
}

TEST_F(SelectedPosesOfABracket, ScoreIsLowerIfMuchOfThePoseIsOutsideTheImage) {
  const CameraIntrinsics& k = cloud_.intrinsics;
  const Eigen::Vector3d center_C = BracketPose() * models_[0].center_O.cast<double>();
  const auto logit_of = [&](const Pose& X_CO) {
    const double score =
        CandidateScores(cloud_, models_, distances_, verifiers_, {At(X_CO, 0.2f)}, {}).front();
    return std::log(score / (1 - score));
  };
  const double inside = logit_of(BracketPose());
  double last = inside;
  for (const double column : {k.width() - 0.5, k.width() + 5.0}) {
    Pose X_CO = BracketPose();
    X_CO.pretranslate(BackProject(k, column, Project(k, center_C).y(), center_C.z()) - center_C);
    const double share = OutsideShare(k, models_[0], X_CO);
    EXPECT_GT(share, kMaxOutsideShare);
    EXPECT_NEAR(inside - logit_of(X_CO), 2 * (share / kMaxOutsideShare - 1), 1e-4);
    EXPECT_LT(logit_of(X_CO), last);
    last = logit_of(X_CO);
  }
}

TEST_F(SelectedPosesOfABracket, EqualPosesMergeIntoTheBest) {
  const Pose near = Perturbed(BracketPose(), {0, 0, 1}, 1, {0.001, 0, 0});
  const auto kept = Select({At(near, 0.1f), At(BracketPose(), 0.3f), At(near, 0.2f)}, 0.5);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].X_CO.matrix(), BracketPose().matrix());
  EXPECT_TRUE(kept[0].suppressed_X_CO.empty()) << "a merged pose is no rival";
}

TEST_F(SelectedPosesOfABracket, RivalForTheSamePixelsIsRecorded) {
  const Pose turned = Perturbed(BracketPose(), {0, 0, 1}, 180, {0, 0, 0});
  const auto kept = Select({At(turned, 0.1f), At(BracketPose(), 0.3f)}, 0.5);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].X_CO.matrix(), BracketPose().matrix());
  EXPECT_EQ(kept[0].suppressed_X_CO.size(), 1u);
}

TEST_F(SelectedPosesOfABracket, PoseWithoutPixelsIsDropped) {
  const Pose aside = Perturbed(BracketPose(), {0, 0, 1}, 0, {0.12, 0, 0});
  const auto kept = Select({At(aside, 0.9f), At(BracketPose(), 0.3f)}, 0.5);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].X_CO.matrix(), BracketPose().matrix());
}

}  // namespace
}  // namespace pickbed::tests
