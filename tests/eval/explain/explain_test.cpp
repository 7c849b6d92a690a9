#include "eval/explain/explain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "eval/explain/codebook_patches.h"
#include "eval/explain/draw_tiles.h"
#include "perception/features/labelled_patches.h"
#include "scenes/base/error.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr double kSide_m = 0.03;

std::vector<TrueInstance> TwoCubes() {
  return {{ObjectId{0}, Translation({-0.05, 0, 0.5}), 1},
          {ObjectId{0}, Translation({0.05, 0, 0.5}), 0.6}};
}

TEST(PoseJudge, ErrorIsShiftOverDiameterToNearestInstance) {
  const PoseJudge judge(EasyCube(), TwoCubes());
  const double diameter_m = std::sqrt(3) * kSide_m;
  const InstanceMatch exact = judge(ObjectId{0}, Translation({0.05, 0, 0.5}));
  EXPECT_EQ(exact.position, 1);
  EXPECT_NEAR(exact.mssd_diameters, 0, 1e-12);
  const InstanceMatch shifted =
      judge(ObjectId{0}, Translation({-0.05, 0, 0.5 + 0.09 * diameter_m}));
  EXPECT_EQ(shifted.position, 0);
  EXPECT_NEAR(shifted.mssd_diameters, 0.09, 1e-9);
  EXPECT_TRUE(shifted.correct);
  EXPECT_FALSE(judge(ObjectId{0}, Translation({-0.05, 0, 0.5 + 0.11 * diameter_m})).correct);
}

TEST(PoseJudge, InstancesOfAnotherObjectDoNotCount) {
  const ObjectSet objects{Cube(0.03, 0.05, 0.6), Cube(0.02, 0.05, 0.6)};
  const PoseJudge judge(objects, TwoCubes());
  EXPECT_EQ(judge(ObjectId{1}, Translation({0.05, 0, 0.5})).position, -1);
  EXPECT_FALSE(judge(ObjectId{1}, Translation({0.05, 0, 0.5})).correct);
}

TEST(JudgeSet, SecondPoseOfAnInstanceIsNotRight) {
  const PoseJudge judge(EasyCube(), TwoCubes());
  std::vector<PoseHypothesis> poses(3);
  poses[0].X_CO = Translation({0.05, 0, 0.5});
  poses[1].X_CO = Translation({0.051, 0, 0.5});
  poses[2].X_CO = Translation({0, 0, 0.5});
  EXPECT_EQ(JudgeSet(judge, poses),
            (std::vector{Verdict::kRight, Verdict::kSecond, Verdict::kWrong}));
}

// One cube in an image, with what each stage kept of it.
class ExplainedInstance : public testing::Test {
 protected:
  ExplainedInstance()
      : judge_(EasyCube(), {{ObjectId{0}, kTrue, 1}}), models_{MakeModelPoints(*EasyCube()[0])} {
    trace_.cloud.points_C = {Eigen::Vector3f(0, 0, 0.5f - kSide_m / 2)};
    trace_.min_score = 0.5;
  }
  InstanceDiagnosis Outcome(const std::vector<PoseHypothesis>& answer = {}) const {
    std::vector<InstanceMatch> errors;
    for (const TracedVote& vote : trace_.votes)
      errors.push_back(judge_(ObjectId{0}, vote.vote.X_CO));
    return DiagnoseInstances(judge_, trace_, errors, models_, answer).front();
  }
  static RawHypothesis Raw(double off_diameters) {
    RawHypothesis raw;
    raw.X_CO = Off(off_diameters);
    return raw;
  }
  static PoseHypothesis Scored(double off_diameters, double score) {
    PoseHypothesis hypothesis;
    hypothesis.X_CO = Off(off_diameters);
    hypothesis.score = score;
    return hypothesis;
  }
  static Pose Off(double diameters) {
    return Translation({0, 0, 0.5 + diameters * std::sqrt(3) * kSide_m});
  }

  static inline const Pose kTrue = Translation({0, 0, 0.5});
  PoseJudge judge_;
  std::vector<ModelPoints> models_;
  EstimateTrace trace_;
};

TEST_F(ExplainedInstance, FailingStageIsTheFirstWithoutARightPose) {
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kPoints);
  trace_.patches.resize(1);
  EXPECT_EQ(Outcome().points, 1);
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kVotes);
  trace_.votes = {{0, Raw(0.4)}};
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kVotes) << "the vote is too far away";
  trace_.votes.push_back({0, Raw(0.2)});
  EXPECT_EQ(Outcome().votes_near, 1);
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kSelection);
  trace_.refinements = {{Raw(0.2), Raw(0.3), false}};
  EXPECT_NEAR(Outcome().best_start, 0.2, 1e-9);
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kIcp);
  trace_.refinements.push_back({Raw(0.2), Raw(0.02), false});
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kMerging);
  trace_.candidates = {{Scored(0.02, 0.4), {}}};
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kVerifier);
  trace_.candidates.push_back({Scored(0.02, 0.8), {}});
  EXPECT_EQ(Outcome().best_score, 0.8);
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kPoseSelection);
  trace_.accepted = {Scored(0.02, 0.8)};
  EXPECT_EQ(Outcome({Scored(0.3, 0.8)}).failing_stage, FailingStage::kRefiner);
  EXPECT_EQ(Outcome({Scored(0.01, 0.8)}).failing_stage, FailingStage::kFound);
}

TEST_F(ExplainedInstance, CountLimitDiffersFromPoseSelection) {
  trace_.candidates = {{Scored(0.02, 0.8), {}}};
  trace_.accepted = {Scored(0.5, 0.9)};
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kPoseSelection) << "no count is given";
  trace_.instances = {1};
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kCount);
  trace_.instances = {2};
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kPoseSelection)
      << "one more instance was expected";
  trace_.instances = {1};
  trace_.accepted = {Scored(0.5, 0.7)};
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kPoseSelection)
      << "the accepted pose has the lower score";
}

TEST_F(ExplainedInstance, BarelyVisibleInstancesNeedNotBeFound) {
  judge_ = PoseJudge(EasyCube(), {{ObjectId{0}, kTrue, 0.05}});
  EXPECT_EQ(Outcome().failing_stage, FailingStage::kHardlyVisible);
  EXPECT_EQ(Outcome({Scored(0.01, 0.8)}).failing_stage, FailingStage::kFound);
}

// A patch rendered only from the pose of an entry equals the patch from which the entry was made.
TEST(EntryPatches, RenderedPatchEqualsTheOriginal) {
  RayCastViews views({ObjectOf(BracketMesh())}, 0);
  const double side_m = 0.03, distance_m = 0.4;
  const Pose X_CO = MakePose(BracketPose().linear(), {0, 0, distance_m});
  const LabelledView view = views.Isolated(ObjectId{0}, {X_CO}, SmallCamera(), 0).front();
  const OrganizedCloud cloud = IsolatedCloud(view);
  std::vector<EntryPose> entries;
  std::vector<std::vector<int8_t>> originals;
  for (const double angle : {0.0, 1.1, 4.0}) {
    const int pixel = cloud.foreground_pixels[cloud.foreground_pixels.size() / 2];
    const PatchSet cut = CutPatches(cloud, {&pixel, 1}, {&angle, 1}, {side_m});
    entries.push_back({ObjectId{0}, {side_m}, cut.X_CP[0].inverse() * X_CO});
    originals.push_back(cut.values);
  }
  const auto anew = EntryPatches(views, entries, distance_m, SmallCamera().fx());
  const auto mean_gap = [&](size_t a, size_t b) {
    double sum = 0;
    for (int i = 0; i < kPatchArea; ++i) sum += std::abs((*anew[a])[i] - originals[b][i]);
    return sum / kPatchArea;
  };
  for (size_t i = 0; i < entries.size(); ++i) {
    ASSERT_TRUE(anew[i]);
    EXPECT_LT(mean_gap(i, i), 6) << "of 254 steps of depth";
    EXPECT_GT(mean_gap(i, (i + 1) % 3), 12) << "another rotation about the ray looks different";
  }
}

TEST(DrawExplain, VoteMapIsBrightestAtMostVotes) {
  RgbdFrame frame{{400, 300, 300, 300, 199.5, 149.5}, Image<Rgb8>(400, 300), {}};
  const Board board(frame, {0, 0, frame.intrinsics.width(), frame.intrinsics.height()});
  std::vector<Eigen::Vector2d> centers(9, {100, 80});
  centers.push_back({300, 200});
  const Image<Rgb8> map = DrawVoteMap(board, centers, 2, {}, {});
  const auto brightness = [&](const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d at = board.At(pixel);
    const Rgb8 p = map(static_cast<int>(at.x()), static_cast<int>(at.y()));
    return p.r + p.g + p.b;
  };
  EXPECT_GT(brightness({100, 80}), brightness({300, 200}) + 100);
  EXPECT_GT(brightness({300, 200}), brightness({200, 20}) + 100);
}

TEST(DrawExplain, FarDepthIsBluerAndUnknownIsDark) {
  PatchValues values{};
  const auto set = [&](int i, int depth, int normal_z) {
    values[i] = static_cast<int8_t>(depth);
    values[3 * kPatchArea + i] = static_cast<int8_t>(normal_z);
  };
  set(0, -100, -127);
  set(1, 100, -127);
  set(2, 127, 0);
  const Image<Rgb8> picture = PatchPicture(values, PatchChannels::kDepthNormals);
  EXPECT_GT(picture(0, 0).r, picture(0, 0).b);
  EXPECT_GT(picture(1, 0).b, picture(1, 0).r);
  EXPECT_LT(picture(2, 0).r + picture(2, 0).g + picture(2, 0).b, 180);
}

TEST(DrawExplain, ColorPatchesKeepTheirColors) {
  PatchValues values{};
  std::fill_n(values.begin(), kPatchArea, 127);
  values[0] = 20;
  values[kPatchArea] = values[3 * kPatchArea] = -127;
  values[2 * kPatchArea] = 127;
  const Image<Rgb8> picture = PatchPicture(values, PatchChannels::kDepthColor);
  EXPECT_EQ(picture(0, 0), (Rgb8{0, 255, 0}));
  EXPECT_LT(picture(1, 0).r, 60) << "background is dark, not medium grey";
}

TEST(SquareCrop, SquareIsEnlargedAboutItsCenter) {
  Image<Rgb8> image(40, 30);
  image(20, 10) = {255, 255, 255};
  const Image<Rgb8> tile = SquareCrop(image, {20, 10}, 5, 25);
  EXPECT_EQ(tile(12, 12), (Rgb8{255, 255, 255}));
  EXPECT_EQ(tile(2, 2), Rgb8{});
}

// Explanation pages of images with and without objects. All their pictures must exist.
class ExplanationPageTest : public testing::Test {
 protected:
  std::string Write(const EstimateTrace& trace, const std::vector<PoseHypothesis>& answer,
                    const std::optional<std::vector<TrueInstance>>& truth) {
    std::filesystem::remove_all(folder_.path() / "page");
    const ExplanationPage page = WriteAs("trial_3", trace, answer, truth);
    unwritten_ = page.unwritten;
    if (!unwritten_.empty()) return "";
    std::ifstream file(folder_.path() / "page" / "explain_trial_3.html");
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  ExplanationPage WriteAs(const std::string& image, const EstimateTrace& trace,
                          const std::vector<PoseHypothesis>& answer,
                          const std::optional<std::vector<TrueInstance>>& truth) {
    return WriteExplanation(
        {"a < b", image, frame_, views_.objects(), trace, answer, truth, views_, 0.5},
        folder_.path() / "page");
  }
  void ExpectPicturesExist(const std::string& page) const {
    const std::regex source("src=\"([^\"]*)\"");
    int count = 0;
    for (std::sregex_iterator it(page.begin(), page.end(), source), end; it != end; ++it) {
      EXPECT_TRUE(std::filesystem::exists(folder_.path() / "page" / (*it)[1].str())) << (*it)[1];
      ++count;
    }
    EXPECT_GE(count, 6);
  }
  EstimateTrace Trace(const LabelledView& view) const {
    EstimateTrace trace;
    trace.cloud = IsolatedCloud(view);
    trace.neighbors = 1;
    return trace;
  }

  TemporaryFolder folder_;
  std::string unwritten_;  // reason why there is no page
  RayCastViews views_{{ObjectOf(BracketMesh())}};
  LabelledView view_ = views_.ClutterScene({3, 1}).front();
  RgbdFrame frame_ = view_.frame;
};

TEST_F(ExplanationPageTest, EmptyImageGivesAPage) {
  frame_.depth_m = Image<float>(frame_.depth_m.width(), frame_.depth_m.height());
  LabelledView nothing;
  nothing.frame = frame_;
  for (const auto& truth :
       {std::optional<std::vector<TrueInstance>>(),
        std::optional(std::vector<TrueInstance>{{ObjectId{0}, BracketPose(), 1}})}) {
    const std::string page = Write(Trace(nothing), {}, truth);
    if (!unwritten_.empty()) GTEST_SKIP() << unwritten_;
    ExpectPicturesExist(page);
    EXPECT_THAT(page, HasSubstr("a &lt; b"));
    EXPECT_THAT(page, HasSubstr("No pose was accepted"));
  }
}

TEST_F(ExplanationPageTest, PagesOfTwoImagesDoNotMixAndAReplacedPageIsReported) {
  const EstimateTrace trace = Trace(view_);
  const ExplanationPage of_trial = WriteAs(TrialImageName(3), trace, {}, std::nullopt);
  if (!of_trial.unwritten.empty()) GTEST_SKIP() << of_trial.unwritten;
  const ExplanationPage of_image = WriteAs(DatasetImageName(3, 0), trace, {}, std::nullopt);
  EXPECT_NE(of_trial.file, of_image.file);
  EXPECT_FALSE(of_trial.replaced);
  EXPECT_FALSE(of_image.replaced);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "page/pictures/trial_3/1_depth.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "page/pictures/image_3_0/1_depth.png"));
  EXPECT_TRUE(WriteAs(TrialImageName(3), trace, {}, std::nullopt).replaced);
}

TEST_F(ExplanationPageTest, EveryStageHasAPicture) {
  EstimateTrace trace = Trace(view_);
  const int pixel = trace.cloud.foreground_pixels[100];
  const double angle = 0;
  const PatchSet cut = CutPatches(trace.cloud, {&pixel, 1}, {&angle, 1}, {0.03});
  TracePatches({&pixel, 1}, cut, 0.03, trace);
  const LabelledInstance& instance = view_.instances[0];
  RawHypothesis raw;
  raw.X_CO = instance.X_CO;
  trace.votes = {{0, raw}};
  trace.refinements = {{raw, raw, false}};
  std::vector<PoseHypothesis> answer(1);
  answer[0].X_CO = instance.X_CO;
  answer[0].score = 0.9;
  trace.candidates = {{answer[0], {}}};
  trace.accepted = answer;
  const std::string page =
      Write(trace, answer, std::vector<TrueInstance>{{ObjectId{0}, instance.X_CO, 1}});
  if (!unwritten_.empty()) GTEST_SKIP() << unwritten_;
  ExpectPicturesExist(page);
  for (const char* picture :
       {"1_depth", "1_foreground", "2_points", "3_patches", "4_votes", "4_votes_by_truth",
        "5_before_icp", "5_after_icp", "6_accepted", "7_final", "8_parts"}) {
    EXPECT_THAT(page, HasSubstr(std::string("pictures/trial_3/") + picture + ".png"));
  }
  EXPECT_THAT(page, HasSubstr("1 of the 1 reported poses are right"));
}

TEST(RequireExplains, ErrorNamesTheEstimatorsThatExplain) {
  RequireExplains("descriptor");
  try {
    RequireExplains("ppf");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'ppf'"));
    EXPECT_THAT(error.what(), HasSubstr(": descriptor"));
  }
}

}  // namespace
}  // namespace pickbed::tests
