#include "perception/verify/color_consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/candidates/pose_selection.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::Each;

constexpr double kSide_m = 0.03, kScore = 0.9;
constexpr int kCubes = 8;
constexpr Rgb8 kRed{200, 70, 60}, kGrey{140, 140, 144};

// Two rows of cubes that face the camera. Each cube has one color.
class RowsOfCubes : public ::testing::Test {
 protected:
  RowsOfCubes() {
    SyntheticDepth scene(SmallCamera());
    for (int i = 0; i < kCubes; ++i) {
      PoseHypothesis h;
      h.X_CO = Translation({(i % 4 - 1.5) * 0.05, (i / 4 - 0.5) * 0.05, 0.4});
      h.score = kScore;
      scene.AddMesh(object_->mesh_O, h.X_CO);
      hypotheses_.push_back(h);
    }
    cloud_ = BuildCloud(scene.frame(), std::nullopt, CloudOptions{.min_plane_share = 1});
    cloud_.color = Image<Rgb8>(cloud_.depth_m.width(), cloud_.depth_m.height());
  }
  void Paint(int cube, const Rgb8& color) {
    for (size_t i = 0; i < cloud_.points_C.size(); ++i) {
      const Eigen::Vector3d off =
          cloud_.points_C[i].cast<double>() - hypotheses_[cube].X_CO.translation();
      if (off.cwiseAbs().maxCoeff() < 0.6 * kSide_m) cloud_.color.data()[i] = color;
    }
  }
  void PaintAll(const Rgb8& color) {
    for (int i = 0; i < kCubes; ++i) Paint(i, color);
  }
  std::vector<double> Scores() const {
    std::vector<PoseHypothesis> lowered = hypotheses_;
    const CommonColors colors(cloud_, models_, hypotheses_);
    std::vector<double> scores;
    for (PoseHypothesis& h : lowered) {
      const double before = h.score;
      const bool is_lowered = colors.LowerIfOdd(h);
      EXPECT_EQ(is_lowered, h.score < before);
      scores.push_back(h.score);
    }
    return scores;
  }

  std::shared_ptr<const ObjectModel> object_ =
      ObjectOf(BoxMesh({kSide_m, kSide_m, kSide_m}, Eigen::Vector3d::Zero()));
  std::vector<ModelPoints> models_{MakeModelPoints(*object_)};
  std::vector<PoseHypothesis> hypotheses_;
  OrganizedCloud cloud_;
};

TEST_F(RowsOfCubes, CubeOfAnotherColorScoresLess) {
  PaintAll(kRed);
  EXPECT_THAT(Scores(), Each(kScore));
  Paint(2, kGrey);
  const std::vector<double> scores = Scores();
  for (int i = 0; i < kCubes; ++i) EXPECT_EQ(scores[i] == kScore, i != 2) << i;
  EXPECT_LT(scores[2], 0.2);
  EXPECT_GT(scores[2], 0);
}

TEST_F(RowsOfCubes, ManyPosesOfADistractorDoNotOutvoteTheObjects) {
  PaintAll(kRed);
  Paint(2, kGrey);
  std::vector<PoseHypothesis> all = hypotheses_;
  all.resize(3 * kCubes, hypotheses_[2]);
  const CommonColors colors(cloud_, models_, hypotheses_);
  for (PoseHypothesis& h : all) colors.LowerIfOdd(h);
  EXPECT_EQ(all[0].score, kScore);
  for (int i = kCubes; i < 3 * kCubes; ++i) EXPECT_LT(all[i].score, 0.2);
}

// Without color consistency the distractor would be among the seven known instances.
TEST_F(RowsOfCubes, DistractorTakesNoPlaceInTheCount) {
  PaintAll(kRed);
  Paint(2, kGrey);
  cloud_.background = BackgroundKind::kKnown;  // else scores of small objects are lowered
  Verifier even;                               // score 0.95 for all candidates
  even.known.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  even.known.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  even.known.w1 = Eigen::MatrixXf::Zero(1, kVerifyFeatures);
  even.known.b1 = even.known.w2 = Eigen::VectorXf::Zero(1);
  even.known.b2 = 3;
  even.unknown = even.known;
  std::vector<Candidate> candidates(kCubes);
  for (int i = 0; i < kCubes; ++i) candidates[i].hypothesis.X_CO = hypotheses_[i].X_CO;
  PoseSelectionOptions options;
  options.min_score = 0.05;
  const std::vector<PoseDistance> distances{PoseDistance(*object_)};
  const int count = kCubes - 1;
  const auto set =
      SelectPoses(cloud_, models_, distances, {&even, 1}, candidates, options, {&count, 1});
  ASSERT_EQ(set.size(), static_cast<size_t>(count));
  for (const PoseHypothesis& h : set) EXPECT_EQ(h.score, even.Score({}));
}

TEST_F(RowsOfCubes, ShadowAndTintAreTolerated) {
  for (int i = 0; i < kCubes; ++i) {
    const double light = 1 - 0.08 * i;
    Paint(i, {static_cast<uint8_t>(light * kRed.r), static_cast<uint8_t>(light * 0.8 * kRed.g),
              static_cast<uint8_t>(light * 0.5 * kRed.b)});
  }
  EXPECT_THAT(Scores(), Each(kScore));
}

TEST_F(RowsOfCubes, NoScoreFallsIfAllColorsDiffer) {
  const Rgb8 toys[kCubes] = {{200, 60, 60},  {60, 200, 60},  {60, 60, 200},   {200, 200, 60},
                             {60, 200, 200}, {200, 60, 200}, {140, 140, 140}, {220, 130, 50}};
  for (int i = 0; i < kCubes; ++i) Paint(i, toys[i]);
  EXPECT_THAT(Scores(), Each(kScore));
}

TEST_F(RowsOfCubes, LowScoresDoNotDefineTheCommonColor) {
  PaintAll(kGrey);
  for (int i = 0; i < 5; ++i) Paint(i, kRed);
  for (int i = 0; i < 5; ++i) hypotheses_[i].score = 0.3;
  EXPECT_EQ(Scores()[0], 0.3) << "three poses are too few";
  for (int i = 0; i < 5; ++i) hypotheses_[i].score = kScore;
  for (int i = 5; i < kCubes; ++i) hypotheses_[i].score = 0.3;
  EXPECT_EQ(Scores()[0], kScore);
  EXPECT_LT(Scores()[5], 0.01);
}

TEST_F(RowsOfCubes, EachObjectHasItsOwnCommonColor) {
  models_.push_back(models_[0]);
  for (int i = 0; i < kCubes; ++i) Paint(i, i < 5 ? kRed : kGrey);
  for (int i = 5; i < kCubes; ++i) hypotheses_[i].object = ObjectId{1};
  EXPECT_THAT(Scores(), Each(kScore));
}

TEST_F(RowsOfCubes, UndecidablePosesAreUnchanged) {
  PaintAll(kRed);
  Paint(2, {10, 10, 10});
  EXPECT_EQ(Scores()[2], kScore) << "too dark";
  Paint(2, kGrey);
  models_[0].texture.colors.resize(models_[0].points_O.size());
  EXPECT_EQ(Scores()[2], kScore) << "textured";
  models_[0].texture.colors.clear();
  EXPECT_LT(Scores()[2], kScore);
  cloud_.color = {};
  EXPECT_EQ(Scores()[2], kScore) << "no colors";
}

}  // namespace
}  // namespace pickbed::tests
