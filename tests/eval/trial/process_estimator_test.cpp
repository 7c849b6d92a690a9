#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "eval/summary/run_csv.h"
#include "eval/trial/observer.h"
#include "eval/trial/trial.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/plugin_scripts.h"

// Trials whose estimator is another program (perception/estimators/process.h).

namespace pickbed::tests {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string Record(const TrialResult& result) {
  return TrialsCsv({result}) + AttemptsCsv({result}, {"cube"});
}

ScenarioSpec ProcessScenario(int count, const std::vector<std::string>& command) {
  ScenarioSpec spec = CubeScenario(count);
  spec.estimator.name = "process";
  spec.estimator.command = command;
  spec.estimator.timeout_s = 30;
  spec.estimator.min_score = 0;
  return spec;
}

// Writes the true poses of each image to a file before they are estimated, one line each: score,
// then R and t row by row.
class TruthWriter : public TrialObserver {
 public:
  explicit TruthWriter(std::filesystem::path file) : file_(std::move(file)) {}

  void OnStage(TrialStage stage, const AttemptState& attempt) override {
    if (stage != TrialStage::kImage) return;
    std::ofstream file(file_);
    file.precision(17);
    const Pose X_CW = attempt.cell.camera().X_CW();
    for (size_t i = 0; i < attempt.scene.objects.size(); ++i) {
      const double visible = attempt.view->visible_fractions[i];
      if (visible < kCountedVisibility) continue;
      const Pose X_CO = X_CW * attempt.scene.objects[i].X_WO;
      file << visible;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) file << ' ' << X_CO(row, column);
      }
      file << '\n';
    }
  }

 private:
  std::filesystem::path file_;
};

TEST(ProcessEstimatorTrial, TheTruthFromAProgramGivesTheTrialOfTheOracle) {
  const TemporaryFolder folder;
  TruthWriter truth(folder.path() / "truth.txt");
  const auto command = PythonCommand(
      folder, "truth.py",
      EstimatorCode("    rows = np.loadtxt('" + (folder.path() / "truth.txt").string() +
                    "', ndmin=2)\n"
                    "    X = rows[:, 1:].reshape(-1, 3, 4)\n"
                    "    return [pb.Pose('cube', x[:, :3], x[:, 3], r[0]) for x, r in zip(X, "
                    "rows)]"));
  ScenarioSpec oracle = CubeScenario(6);
  oracle.policy.max_failures_in_row = 3;
  ScenarioSpec process = ProcessScenario(6, command);
  process.policy = oracle.policy;
  TrialRunner oracle_runner(oracle, EasyCube()), process_runner(process, EasyCube());
  for (const int bin : {0, 1}) {
    const TrialResult expected = oracle_runner.Run(BinIndex(bin));
    const TrialResult got = process_runner.Run(BinIndex(bin), &truth);
    EXPECT_GT(expected.instances_cleared, 0);
    EXPECT_EQ(got.instances_cleared, expected.instances_cleared);
    EXPECT_EQ(Record(got), Record(expected));
  }
}

// The program reports the true pose of the only cube, but fails in the image of its choice.
class FailingProgram : public testing::Test {
 protected:
  TrialResult Run(const std::string& failure, double timeout_s = 30) {
    const auto command = PythonCommand(
        folder_, "failing.py",
        EstimatorCode("    first = not os.path.exists('" + (folder_.path() / "seen").string() +
                      "')\n    open('" + (folder_.path() / "seen").string() + "', 'w')\n" +
                      "    if first: " + failure + "\n    rows = np.loadtxt('" +
                      (folder_.path() / "truth.txt").string() +
                      "', ndmin=2)\n    X = rows[:, 1:].reshape(-1, 3, 4)\n"
                      "    return [pb.Pose('cube', x[:, :3], x[:, 3], r[0]) for x, r in zip(X, "
                      "rows)]"));
    ScenarioSpec spec = ProcessScenario(1, command);
    spec.estimator.timeout_s = timeout_s;
    TrialOptions options;
    options.log_dir = folder_.path() / "logs";
    options.on_warning = [this](const std::string& line) { warnings_.push_back(line); };
    TruthWriter truth(folder_.path() / "truth.txt");
    return TrialRunner(spec, EasyCube(), {}, options).Run(BinIndex(1), &truth);
  }

  TemporaryFolder folder_;
  std::vector<std::string> warnings_;
};

TEST_F(FailingProgram, ACrashCostsOneAttempt) {
  const TrialResult result = Run("os._exit(9)");
  ASSERT_EQ(result.attempts.size(), 2u);
  EXPECT_EQ(result.attempts[0].failure, FailureReason::kEstimatorCrashed);
  EXPECT_EQ(result.attempts[0].instances.at(0).missed, FailureReason::kEstimatorCrashed);
  EXPECT_EQ(result.attempts[1].failure, FailureReason::kNone);
  EXPECT_EQ(result.instances_cleared, 1);
  EXPECT_EQ(result.ended_by, FailureReason::kNone);
  EXPECT_THAT(warnings_, Contains("bin 1, attempt 0: estimator 'tested' ended with status 9"));
}

TEST_F(FailingProgram, AnErrorShowsItsTraceback) {
  const TrialResult result = Run("raise ValueError('planted')");
  ASSERT_EQ(result.attempts.size(), 2u);
  EXPECT_EQ(result.attempts[0].failure, FailureReason::kEstimatorCrashed);
  EXPECT_EQ(result.instances_cleared, 1);
  EXPECT_THAT(warnings_, Contains(HasSubstr("ValueError: planted")));
  EXPECT_THAT(warnings_, Contains(HasSubstr("failing.py\", line")));
  EXPECT_THAT(ReadFileBytes(folder_.path() / "logs/estimator_1.log"),
              HasSubstr("ValueError: planted"));
}

TEST_F(FailingProgram, AHangCostsOneAttempt) {
  const TrialResult result = Run("time.sleep(60)", 4);
  ASSERT_EQ(result.attempts.size(), 2u);
  EXPECT_EQ(result.attempts[0].failure, FailureReason::kEstimatorTimeout);
  EXPECT_EQ(result.instances_cleared, 1);
}

// A program that dies says nothing about the bin. So only failed grasps count towards a stir, and
// the robot misses the cube by centimetres. The program dies in the second image.
TEST(ProcessEstimatorTrial, ADeadProgramDoesNotCountTowardsAStir) {
  const TemporaryFolder folder;
  const std::string seen = (folder.path() / "seen").string();
  const auto command = PythonCommand(
      folder, "dying.py",
      EstimatorCode("    n = len(open('" + seen + "').read()) if os.path.exists('" + seen +
                    "') else 0\n    open('" + seen + "', 'a').write('x')\n" +
                    "    if n == 1: os._exit(9)\n    rows = np.loadtxt('" +
                    (folder.path() / "truth.txt").string() +
                    "', ndmin=2)\n    X = rows[:, 1:].reshape(-1, 3, 4)\n"
                    "    return [pb.Pose('cube', x[:, :3], x[:, 3], r[0]) for x, r in zip(X, "
                    "rows)]"));
  ScenarioSpec spec = ProcessScenario(1, command);
  spec.cell.repeatability_mm = 60;
  spec.policy.stop = "capture_again";
  spec.policy.max_failures_in_row = 6;
  spec.policy.stir.max = 1;
  spec.policy.stir.after = 5;
  spec.policy.stir.after_failures = 2;
  TruthWriter truth(folder.path() / "truth.txt");
  const TrialResult result = TrialRunner(spec, EasyCube()).Run(BinIndex(0), &truth);
  ASSERT_GE(result.attempts.size(), 4u);
  EXPECT_TRUE(result.attempts[0].grasp);
  EXPECT_EQ(result.attempts[1].failure, FailureReason::kEstimatorCrashed);
  EXPECT_NE(result.attempts[2].failure, FailureReason::kStirred) << "one grasp failed, not two";
  EXPECT_TRUE(result.attempts[2].grasp);
  EXPECT_EQ(result.attempts[3].failure, FailureReason::kStirred) << "two grasps failed";
}

TEST(ProcessEstimatorTrial, TheFirstImageOfARunNeedsAValidAnswer) {
  const TemporaryFolder folder;
  const auto command =
      PythonCommand(folder, "mm.py", EstimatorCode("    return [pose(x=10, z=800)]"));
  TrialRunner runner(ProcessScenario(1, command), EasyCube());
  EXPECT_THAT(ErrorOf([&] { runner.Run(BinIndex(0)); }), HasSubstr("t_m is in millimetres"));
  EXPECT_EQ(runner.Run(BinIndex(1)).attempts.at(0).failure, FailureReason::kEstimatorCrashed);
}

// The same for a planner that is a program.
TEST(ProcessEstimatorTrial, TheFirstImageOfARunNeedsAValidPlan) {
  const TemporaryFolder folder;
  ScenarioSpec spec = CubeScenario(1);
  spec.planner.name = "process";
  spec.planner.command =
      PythonCommand(folder, "mm.py",
                    "import numpy as np\nimport pickbed_plugin as pb\n@pb.planner\n"
                    "def tested(frame, poses):\n    return [pb.Grasp(np.eye(4), 30, 0.9)]\n"
                    "pb.serve()\n");
  TrialRunner runner(spec, EasyCube());
  EXPECT_THAT(
      ErrorOf([&] { runner.Run(BinIndex(0)); }),
      HasSubstr("planner 'tested' gave a wrong grasp (number 0): width_m is in millimetres"));
  EXPECT_EQ(runner.Run(BinIndex(1)).attempts.at(0).failure, FailureReason::kPlannerCrashed);
}

// Raw scores rank the poses of an image. The record keeps them.
TEST(ProcessEstimatorTrial, RawScoresAreKeptAndRanked) {
  const TemporaryFolder folder;
  TruthWriter truth(folder.path() / "truth.txt");
  const auto command = PythonCommand(
      folder, "raw.py",
      EstimatorCode("    rows = np.loadtxt('" + (folder.path() / "truth.txt").string() +
                    "', ndmin=2)\n"
                    "    X = rows[:, 1:].reshape(-1, 3, 4)\n"
                    "    assert known.min_score <= 0\n"
                    "    return [pb.Pose('cube', x[:, :3], x[:, 3], 100 * r[0] - 220) for x, r in "
                    "zip(X, rows)]"));
  ScenarioSpec spec = ProcessScenario(3, command);
  EXPECT_THAT(ErrorOf([&] { TrialRunner(spec, EasyCube()).Run(BinIndex(0), &truth); }),
              HasSubstr("pickbed calibrate"));
  spec.estimator.scores = "raw";
  spec.estimator.min_score = 0.9;
  const TrialResult result = TrialRunner(spec, EasyCube()).Run(BinIndex(0), &truth);
  const auto& poses = result.attempts.at(0).hypotheses;
  ASSERT_EQ(poses.size(), 3u) << "the minimum score does not apply";
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(poses[i].score, 1 - i / 3.0, 1e-12);
    EXPECT_LE(poses[i].raw_score, -120);
    EXPECT_LE(poses[i].raw_score, poses[i == 0 ? 0 : i - 1].raw_score);
  }
  EXPECT_GT(result.instances_cleared, 0);
}

}  // namespace
}  // namespace pickbed::tests
