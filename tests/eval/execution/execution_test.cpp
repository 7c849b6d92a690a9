#include "eval/execution/execution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "eval/bop/layout.h"
#include "eval/execution/image_executor.h"
#include "eval/execution/statistics.h"
#include "eval/trial/trial.h"
#include "scenes/base/error.h"
#include "tests/eval/execution/executed_dataset.h"
#include "tests/support/error_of.h"
#include "tests/support/plugin_scripts.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr int kScenes = 5;

class ExecutionTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { set_ = new ExecutedDataset(kScenes, 1); }
  static void TearDownTestSuite() { delete set_; }

  // Estimates that are wrong by 0, 8, 16, ... mm along the camera's x axis.
  static std::vector<DatasetEstimate> Shifted() {
    std::vector<DatasetEstimate> estimates = set_->Truth();
    for (size_t i = 0; i < estimates.size(); ++i) {
      estimates[i].X_CO.pretranslate(Eigen::Vector3d(0.008 * static_cast<double>(i % 6), 0, 0));
    }
    return estimates;
  }

  static ExecutedDataset* set_;
};
ExecutedDataset* ExecutionTest::set_ = nullptr;

TEST_F(ExecutionTest, TruePosesFromAFileSucceedAsTheOracleDoes) {
  ExecutionOptions options = set_->Options("oracle", {set_->Write("truth.csv", set_->Truth())});
  options.oracle = true;
  const ExecutionReport report = Execute(options);
  ASSERT_EQ(report.methods, (std::vector<std::string>{"truth", kTruePosesMethod}));
  EXPECT_EQ(report.images, kScenes);
  const size_t half = report.picks.size() / 2;
  int successes = 0;
  std::map<std::tuple<int, int, int>, std::pair<FailureReason, InstanceId>> truth;
  for (const ExecutedPick& pick : report.picks) {
    const auto key = std::tuple(pick.scene_id, pick.image_id, pick.pick);
    if (pick.method == "truth") {
      truth.insert({key, {pick.failure, pick.instance}});
      successes += pick.success;
      EXPECT_LT(pick.executed() ? pick.errors.mssd_m : 0, 1e-9);
      EXPECT_LT(pick.executed() ? pick.errors.vsd : 0, 1e-9);
      continue;
    }
    EXPECT_EQ(truth.at(key).first, pick.failure);
    EXPECT_EQ(int{truth.at(key).second}, int{pick.instance});
  }
  EXPECT_EQ(truth.size(), half);
  EXPECT_GT(successes, kScenes);
}

TEST_F(ExecutionTest, SameBytesForAnyNumberOfJobsAndAfterAStop) {
  const std::vector<std::filesystem::path> files{set_->Write("a.csv", set_->Truth()),
                                                 set_->Write("b.csv", Shifted())};
  Execute(set_->Options("one", files));
  ExecutionOptions two = set_->Options("two", files);
  two.jobs = 2;
  Execute(two);
  const std::string picks = set_->Bytes("one/executed_picks.csv");
  EXPECT_EQ(set_->Bytes("two/executed_picks.csv"), picks);

  ExecutionOptions stopped = set_->Options("stopped", files);
  int done = 0;
  const ExecutionListener listener{
      [&](const ExecutionProgress&) { ++done; }, {}, [&] { return done >= 2; }};
  const ExecutionReport first = Execute(stopped, listener);
  EXPECT_TRUE(first.interrupted);
  EXPECT_THAT(ErrorOf([&] { Execute(stopped); }), HasSubstr("resume it"));
  const std::string stored = set_->Bytes("stopped/executed_picks.csv");
  WriteFileAtomically(stopped.out / kPicksFile, stored + "a,3,0,1,");  // cut off by a kill
  stopped.resume = true;
  int before = -1;
  const ExecutionReport second = Execute(
      stopped, {[&](const ExecutionProgress& progress) { before = progress.done_before; }, {}, {}});
  EXPECT_FALSE(second.interrupted);
  EXPECT_GE(before, 2);
  EXPECT_EQ(set_->Bytes("stopped/executed_picks.csv"), picks);

  stopped.picks = 2;
  EXPECT_THAT(ErrorOf([&] { Execute(stopped); }), HasSubstr("other results, settings or scenes"));
  EXPECT_EQ(set_->Bytes("stopped/executed_picks.csv"), picks) << "nothing stored is lost";
}

TEST_F(ExecutionTest, OnlyTheOrderOfTheScoresCounts) {
  std::vector<DatasetEstimate> logits = Shifted();
  for (DatasetEstimate& e : logits) e.score = std::log(e.score) * 1e4 - 77;
  const ExecutionReport report = Execute(set_->Options(
      "scores", {set_->Write("plain.csv", Shifted()), set_->Write("logits.csv", logits)}));
  std::vector<ExecutedPick> plain, scaled;
  for (const ExecutedPick& pick : report.picks) {
    (pick.method == "plain" ? plain : scaled).push_back(pick);
  }
  ASSERT_EQ(plain.size(), scaled.size());
  for (size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain[i].failure, scaled[i].failure);
    EXPECT_EQ(plain[i].executed(), scaled[i].executed());
    if (!plain[i].executed()) continue;
    EXPECT_EQ(plain[i].errors.mssd_m, scaled[i].errors.mssd_m);
  }
}

TEST_F(ExecutionTest, LargerErrorsFailMoreOften) {
  const ExecutionReport report = Execute(set_->Options(
      "errors", {set_->Write("truth.csv", set_->Truth()), set_->Write("shifted.csv", Shifted())}));
  const ExecutionStatistics statistics = StatisticsOf(report.methods, report.picks);
  ASSERT_EQ(statistics.methods.size(), 2u);
  EXPECT_GT(statistics.methods[0].requested.rate(), statistics.methods[1].requested.rate());
  const PredictorAuc& mssd = statistics.predictors.at(1);
  ASSERT_EQ(mssd.name, "mssd");
  EXPECT_GT(mssd.auc.auc, 0.8);
  for (const ExecutedPick& pick : report.picks) {
    if (!pick.executed()) continue;
    // The cube keeps its rotation, so all its points are off by the same distance.
    EXPECT_NEAR(pick.errors.add_m, pick.errors.mssd_m, 1e-6);
    EXPECT_GE(pick.errors.vsd, 0);
    EXPECT_LE(pick.errors.vsd, 1);
  }
}

TEST_F(ExecutionTest, AnImageWithoutEstimatesFailsAsNotProposed) {
  std::vector<DatasetEstimate> estimates = set_->Truth();
  std::erase_if(estimates, [](const DatasetEstimate& e) { return e.scene_id == 2; });
  std::vector<std::string> warnings;
  const ExecutionReport report =
      Execute(set_->Options("missing", {set_->Write("some.csv", estimates)}),
              {{}, [&](const std::string& line) { warnings.push_back(line); }, {}});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("no estimate for 1 of 5 images, the first is scene 2"));
  int missing = 0;
  for (const ExecutedPick& pick : report.picks) {
    if (pick.scene_id != 2) continue;
    ++missing;
    EXPECT_EQ(pick.failure, FailureReason::kNoProposal);
    EXPECT_FALSE(pick.executed());
  }
  EXPECT_GT(missing, 0);
}

// A run has the same reason: the pose is there, but no grasp may be executed on it.
TEST_F(ExecutionTest, APoseWhoseLiftIsBlockedHasNoGrasp) {
  ScenarioSpec spec = SmallScenario();
  spec.policy.check_lift = true;
  spec.policy.lift_clearance_mm = 1000;  // wider than the bin
  const ExecutionReport report = ExecuteResults(
      spec, EasyCube(), set_->Options("blocked", {set_->Write("truth.csv", set_->Truth())}), {});
  ASSERT_FALSE(report.picks.empty());
  for (const ExecutedPick& pick : report.picks) {
    EXPECT_EQ(FailureName(pick.failure), FailureName(FailureReason::kNoGrasp));
    EXPECT_FALSE(pick.executed());
  }
}

TEST_F(ExecutionTest, TheLogOfAPlannerProgramIsInTheResultsFolder) {
  const TemporaryFolder folder;
  ScenarioSpec spec = SmallScenario();
  spec.planner.name = "process_poses";
  spec.planner.command =
      PythonCommand(folder, "planner.py",
                    "import pickbed_plugin as pb\n@pb.planner\n"
                    "def tested(frame, poses):\n"
                    "    print('seen', len(poses))\n    return []\npb.serve()\n");
  ExecuteResults(spec, EasyCube(),
                 set_->Options("logged", {set_->Write("truth.csv", set_->Truth())}), {});
  EXPECT_THAT(set_->Bytes("logged/logs/planner_1.log"), HasSubstr("seen 3"));
}

TEST_F(ExecutionTest, UnusableInputIsRefusedInOneLine) {
  const auto error_of = [&](const std::vector<DatasetEstimate>& estimates) {
    return ErrorOf([&] { Execute(set_->Options("bad", {set_->Write("bad.csv", estimates)})); });
  };
  std::vector<DatasetEstimate> estimates = set_->Truth();
  for (DatasetEstimate& e : estimates) e.X_CO.translation() *= 1e-3;
  EXPECT_THAT(error_of(estimates), HasSubstr("t is in metres"));
  estimates = set_->Truth();
  for (DatasetEstimate& e : estimates) e.X_CO.translation() *= 1e3;
  EXPECT_THAT(error_of(estimates), HasSubstr("none of its"));
  estimates = set_->Truth();
  estimates.back().scene_id = 48;
  EXPECT_THAT(error_of(estimates), HasSubstr("no scene 48"));
  estimates = set_->Truth();
  estimates.back().image_id = 7;
  EXPECT_THAT(error_of(estimates), HasSubstr("with an image 7"));
  estimates = set_->Truth();
  estimates.front().object_id = 2;
  EXPECT_THAT(error_of(estimates), HasSubstr("bad.csv:2: obj_id 2"));
  EXPECT_THAT(error_of({}), HasSubstr("has no estimate"));
  EXPECT_FALSE(std::filesystem::exists(set_->root().parent_path() / "bad"))
      << "a refused call leaves no folder";

  const auto file = set_->Write("same.csv", set_->Truth());
  EXPECT_THAT(ErrorOf([&] {
                Execute(set_->Options("bad", {file, file}));
              }),
              HasSubstr("another method is also named same"));
  EXPECT_THAT(ErrorOf([&] { Execute(set_->Options("bad", {})); }), HasSubstr("no results file"));
  ScenarioSpec pose_free = SmallScenario();
  pose_free.planner.name = "cloud_antipodal";
  EXPECT_THAT(ErrorOf([&] {
                ExecuteResults(pose_free, EasyCube(), set_->Options("bad_planner", {file}), {});
              }),
              HasSubstr("works without poses"));
  EXPECT_EQ(Execute(set_->Options("bad_planner", {file})).images, kScenes)
      << "a refused call does not block its folder";
}

// A run with the oracle captures the same image of the same bin, and its first pick is the same
// task.
TEST(ExecutionOfAScene, FirstPickOfTheOracleIsTheFirstPickOfARun) {
  const ExecutedDataset set(kScenes, 1);
  ExecutionOptions options = set.Options("first", {});
  options.oracle = true;
  options.picks = 1;
  const ExecutionReport report = Execute(options);
  ASSERT_EQ(report.picks.size(), static_cast<size_t>(kScenes));
  TrialRunner runner(SmallScenario(), EasyCube());
  for (int bin = 0; bin < kScenes; ++bin) {
    const AttemptRecord first = runner.Run(BinIndex(bin)).attempts.front();
    EXPECT_EQ(report.picks[bin].success, first.failure == FailureReason::kNone) << bin;
  }
}

TEST(ExecutionOfAScene, GroundTruthOfAnotherObjectIsRefused) {
  const ExecutedDataset set(1, 1);
  const auto file = set.root() / "test" / SceneFolderName(1) / kSceneTruthFile;
  const std::string was = "\"obj_id\":1";
  std::string text = ReadFileBytes(file);
  const size_t place = text.find(was);
  ASSERT_NE(place, std::string::npos);
  WriteFileAtomically(file, text.replace(place, was.size(), "\"obj_id\":2"));
  ExecutionOptions options = set.Options("out", {});
  options.oracle = true;
  EXPECT_THAT(ErrorOf([&] { Execute(options); }), HasSubstr("do not fit together"));
}

TEST(RequestedPicks, CountsVisibleWantedInstances) {
  ImageTruth image;
  for (const double visible : {1.0, 0.5, 0.05, 0.9}) {
    image.instances.push_back({image.instances.size() == 3 ? 2 : 1, Pose::Identity()});
    image.infos.emplace_back();
    image.infos.back().visib_fract = visible;
  }
  EXPECT_EQ(RequestedPicks(image, {true, false}, 5), 2);
  EXPECT_EQ(RequestedPicks(image, {true, true}, 5), 3);
  EXPECT_EQ(RequestedPicks(image, {true, true}, 1), 1);
}

}  // namespace
}  // namespace pickbed::tests
