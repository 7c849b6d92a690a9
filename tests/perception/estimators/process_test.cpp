#include "perception/estimators/process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"
#include "tests/support/plugin_scripts.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ProcessEstimatorTest : public testing::Test {
 protected:
  ProcessEstimatorTest() {
    frame_.intrinsics = {64, 48, 60, 60, 31.5, 23.5};
    frame_.depth_m = Image<float>(64, 48, 0.8f);
    auto second = std::make_shared<ObjectModel>(*ObjectOf(BracketMesh()));
    second->name = "second";
    setup_.objects = {ObjectOf(BracketMesh()), second};
    setup_.spec.name = "process";
    setup_.spec.timeout_s = 30;
    setup_.spec.min_score = 0;
    setup_.intrinsics = frame_.intrinsics;
    setup_.working_distance_m = 0.8;
    setup_.cache_dir = folder_.path() / "cache";
    setup_.log_dir = folder_.path() / "logs";
  }

  std::unique_ptr<PoseEstimator> Make(const std::string& body, const std::string& needs = "") {
    setup_.spec.command = PythonCommand(folder_, "estimator.py", EstimatorCode(body, needs));
    return MakeEstimator(setup_);
  }
  EstimateResult Estimate(PoseEstimator& estimator, bool is_first = false) {
    Rng rng(1);
    EstimatorInput input{frame_, std::nullopt};
    input.is_first = is_first;
    return estimator.Estimate(input, rng);
  }

  TemporaryFolder folder_;
  RgbdFrame frame_;
  EstimatorSetup setup_;
};

std::vector<double> Scores(const EstimateResult& result) {
  std::vector<double> scores;
  for (const PoseHypothesis& hypothesis : result.hypotheses) scores.push_back(hypothesis.score);
  return scores;
}

TEST_F(ProcessEstimatorTest, PosesAreRankedAndThoseBelowTheMinimumAreLeftOut) {
  setup_.spec.min_score = 0.4;
  const auto estimator =
      Make("    return [pose(0.1, 0.5), pose(0.2, 0.9), pose(0.3, 0.3), pose(0.4, 0.5, 'second')]");
  const EstimateResult result = Estimate(*estimator);
  EXPECT_THAT(Scores(result), ElementsAre(0.9, 0.5, 0.5));
  EXPECT_TRUE(result.hypotheses[0].X_CO.translation().isApprox(Eigen::Vector3d(0.2, 0, 0.8)));
  EXPECT_EQ(result.hypotheses[1].object, ObjectId(0)) << "equal scores keep their order";
  EXPECT_EQ(result.hypotheses[2].object, ObjectId(1));
  EXPECT_EQ(result.seconds.count("process"), 1u);
  EXPECT_FALSE(result.failure);
}

TEST_F(ProcessEstimatorTest, KnownCountsLimitThePosesOfAnObject) {
  const auto estimator = Make(
      "    assert frame.counts == {known.objects[0].name: 1, 'second': 2}\n"
      "    return [pose(0, 0.1 * i, n) for i in range(5) for n in (None, 'second')]",
      "'counts'");
  Rng rng(1);
  EstimatorInput input{frame_, std::nullopt};
  input.instances = {1, 2};
  EXPECT_THAT(Scores(estimator->Estimate(input, rng)), ElementsAre(0.4, 0.4, 0.1 * 3));
  EXPECT_THAT(ErrorOf([&] { Estimate(*estimator); }), HasSubstr("needs 'counts'"));
}

TEST_F(ProcessEstimatorTest, ThePluginGetsTheImageAsItIs) {
  frame_.depth_m(5, 7) = 0.25f;
  frame_.color = Image<Rgb8>(64, 48, Rgb8{1, 2, 3});
  frame_.color(9, 3) = {200, 100, 50};
  const auto estimator = Make(
      "    assert frame.depth_m.shape == (48, 64) and frame.depth_m.dtype == np.float32\n"
      "    assert frame.depth_m[7, 5] == 0.25 and frame.depth_m[0, 0] == np.float32(0.8)\n"
      "    assert list(frame.color[3, 9]) == [200, 100, 50] and list(frame.color[0, 0]) == [1, 2, "
      "3]\n"
      "    assert np.array_equal(frame.K, [[60, 0, 31.5], [0, 60, 23.5], [0, 0, 1]])\n"
      "    assert frame.X_WC[0, 3] == 0.5 and frame.X_CB[2, 3] == 0.75\n"
      "    assert frame.counts is None and known.min_score == 0 and known.mode == 'fast'\n"
      "    p_C = frame.point_image_C()[7, 5]\n"
      "    assert np.allclose(p_C, [(5 - 31.5) / 60 * 0.25, (7 - 23.5) / 60 * 0.25, 0.25])\n"
      "    assert np.array_equal(frame.rng().random(3), np.random.default_rng(frame.seed)"
      ".random(3))\n"
      "    points, normals = known.objects[0].sample(100, frame.rng())\n"
      "    assert np.allclose(np.linalg.norm(normals, axis=1), 1)\n"
      "    low, high = known.objects[0].vertices_m.min(0), known.objects[0].vertices_m.max(0)\n"
      "    assert ((points > low - 1e-9) & (points < high + 1e-9)).all()\n"
      "    assert os.path.getsize(known.objects[0].mesh) > 0\n"
      "    return [pose()]");
  Rng rng(1);
  EstimatorInput input{frame_, KnownBackground{Bin(), Translation({0, 0, 0.75})}};
  input.X_WC = Translation({0.5, 0, 0});
  const EstimateResult result = estimator->Estimate(input, rng);
  EXPECT_FALSE(result.failure) << result.failure->traceback.back();
  EXPECT_EQ(result.hypotheses.size(), 1u);
}

// Each failure costs one image.
TEST_F(ProcessEstimatorTest, AnImageForWhichItFailsHasTheReason) {
  setup_.spec.timeout_s = 4;
  const auto estimator = Make(
      "    mode = int(frame.depth_m[0, 0])\n"
      "    if mode == 1: os._exit(3)\n"
      "    if mode == 2: time.sleep(60)\n"
      "    if mode == 3: return [pose(score=float('nan'))]\n"
      "    if mode == 4: return [1 / 0]\n"
      "    return [pose()]");
  const auto failure_of = [&](int mode) {
    frame_.depth_m(0, 0) = static_cast<float>(mode);
    const EstimateResult result = Estimate(*estimator);
    EXPECT_TRUE(result.failure) << mode;
    EXPECT_TRUE(result.hypotheses.empty());
    frame_.depth_m(0, 0) = 0;
    EXPECT_EQ(Estimate(*estimator).hypotheses.size(), 1u) << "after " << mode;
    return result.failure.value_or(EstimatorFailure());
  };
  EXPECT_EQ(failure_of(1).reason, FailureReason::kEstimatorCrashed);
  EXPECT_EQ(failure_of(2).reason, FailureReason::kEstimatorTimeout);
  EXPECT_EQ(failure_of(3).reason, FailureReason::kEstimatorCrashed);
  EXPECT_THAT(failure_of(3).text, HasSubstr("estimator 'tested' gave a wrong pose (number 0): "
                                            "score is not finite"));
  const EstimatorFailure error = failure_of(4);
  EXPECT_EQ(error.reason, FailureReason::kEstimatorCrashed);
  EXPECT_THAT(error.text, HasSubstr("ZeroDivisionError: division by zero"));
  EXPECT_THAT(error.traceback, testing::Contains(HasSubstr("return [1 / 0]")));
}

TEST_F(ProcessEstimatorTest, AWrongFirstAnswerEndsTheRun) {
  const auto wrong = Make("    return [pose(z=800)]");
  EXPECT_THAT(ErrorOf([&] { Estimate(*wrong, true); }), HasSubstr("t_m is in millimetres"));
  EXPECT_EQ(Estimate(*wrong).failure->reason, FailureReason::kEstimatorCrashed);
  const auto crash = Make("    raise ValueError('no')");
  EXPECT_EQ(Estimate(*crash, true).failure->reason, FailureReason::kEstimatorCrashed)
      << "an error costs the image only, even the first one";
}

TEST_F(ProcessEstimatorTest, ImagesWithoutWhatItNeedsAreRefused) {
  const auto color = Make("    return []", "'color'");
  EXPECT_THAT(ErrorOf([&] { Estimate(*color); }), HasSubstr("needs 'color'; the images have no"));
  const auto bin = Make("    return []", "'bin'");
  EXPECT_THAT(ErrorOf([&] { Estimate(*bin); }), HasSubstr("needs 'bin'"));
}

TEST_F(ProcessEstimatorTest, WithoutAProgramTheErrorNamesTheSettings) {
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(setup_); }), HasSubstr("neither command nor connect"));
}

}  // namespace
}  // namespace pickbed::tests
