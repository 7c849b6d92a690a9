#include "eval/results_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <limits>

#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/random.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class ResultsStoreTest : public testing::Test {
 protected:
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

std::string ErrorOf(const std::function<void()>& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

GraspOutcome FullOutcome(Rng& rng) {
  GraspOutcome outcome{true, Loss::kDropped, 5, 2, rng.Uniform(), rng.Uniform(), rng.Uniform(), 4};
  outcome.is_target = outcome.retreat_contact = outcome.set_down = true;
  outcome.parts_touched = 3;
  outcome.parts_risen = 2;
  outcome.lift_height_m = rng.Uniform();
  outcome.contact_force_n = rng.UnitVector();
  outcome.contact_torque_nm = rng.UnitVector();
  outcome.retreat_opening = rng.Uniform();
  outcome.place_error_m = rng.Uniform();
  outcome.place_turn_rad = rng.Uniform();
  for (size_t i = 0; i < outcome.verdicts.size(); ++i) outcome.verdicts[i] = i % 2 == 0;
  return outcome;
}

// A trial in which no field has its default.
TrialResult FullTrial(int trial) {
  Rng rng(trial + 1);
  TrialResult result;
  result.trial = trial;
  result.certificate.at_rest = true;
  result.certificate.simulated_s = rng.Uniform();
  result.certificate.max_speed_mps = rng.Uniform();
  result.certificate.max_spin_radps = rng.Uniform();
  result.certificate.deepest_penetration_m = rng.Uniform();
  result.certificate.wake_movement_m = rng.Uniform();
  result.certificate.wake_movement_diameters = rng.Uniform();
  result.refused = {{0, {"not at rest", "overlap"}}, {1, {"fell outside"}}};
  result.parts_dropped = 7;
  result.parts_cleared = 3;
  result.ended_by = Loss::kSlipped;
  for (int p = 0; p < 3; ++p) {
    PickRecord& pick = result.picks.emplace_back();
    pick.pick = p;
    for (int i = 0; i < 4; ++i) {
      pick.instances.push_back({i, i % 2, rng.Uniform(), i % 2 == 0, Loss::kSuppressed});
    }
    HypothesisScore score;
    score.object = 1;
    score.instance = 3;
    score.score = rng.Uniform();
    score.mssd_m = rng.Uniform();
    score.mspd_px = rng.Uniform();
    score.add_m = rng.Uniform();
    score.adi_m = rng.Uniform();
    score.rotation_rad = rng.Uniform();
    score.translation_m = rng.Uniform();
    score.mssd_diameters = kInfinity;
    score.correct = true;
    score.X_WO = MakePose(rng.Rotation().toRotationMatrix(), rng.UnitVector());
    score.X_OtrueObelieved = MakePose(rng.Rotation().toRotationMatrix(), rng.UnitVector());
    pick.hypotheses = {score, HypothesisScore()};
    pick.loss = Loss::kNoGrasp;
    pick.grasps_rejected = {{"collision", 12}, {"tilt's", 3}};
    for (uint64_t& hash : pick.hashes.values) hash = rng.Next();
    if (p == 2) continue;  // a look without a grasp
    pick.chosen = 1;
    pick.aimed = 3;
    Grasp grasp;
    grasp.X_WG = MakePose(rng.Rotation().toRotationMatrix(), rng.UnitVector());
    grasp.width_m = rng.Uniform();
    grasp.score = rng.Uniform();
    grasp.hypothesis = 1;
    pick.grasp = grasp;
    pick.outcome = FullOutcome(rng);
  }
  result.fates = {{0, 1, true, true, Loss::kNone, 0}, {1, 0, false, false, Loss::kDisturbed, 2}};
  result.seconds = {{"drop", rng.Uniform()}, {"see", rng.Uniform()}};
  return result;
}

void ExpectSamePick(const PickRecord& a, const PickRecord& b) {
  EXPECT_EQ(a.pick, b.pick);
  EXPECT_EQ(a.chosen, b.chosen);
  EXPECT_EQ(a.aimed, b.aimed);
  EXPECT_EQ(a.loss, b.loss);
  EXPECT_EQ(a.grasps_rejected, b.grasps_rejected);
  EXPECT_EQ(a.hashes, b.hashes);
  ASSERT_EQ(a.grasp.has_value(), b.grasp.has_value());
  if (a.grasp) {
    EXPECT_EQ(a.grasp->X_WG.matrix(), b.grasp->X_WG.matrix());
    EXPECT_EQ(a.grasp->width_m, b.grasp->width_m);
    EXPECT_EQ(a.grasp->score, b.grasp->score);
    EXPECT_EQ(a.grasp->hypothesis, b.grasp->hypothesis);
  }
  EXPECT_EQ(a.outcome.success, b.outcome.success);
  EXPECT_EQ(a.outcome.loss, b.outcome.loss);
  EXPECT_EQ(a.outcome.picked_instance, b.outcome.picked_instance);
  EXPECT_EQ(a.outcome.parts_lifted, b.outcome.parts_lifted);
  EXPECT_EQ(a.outcome.final_opening_m, b.outcome.final_opening_m);
  EXPECT_EQ(a.outcome.slip_m, b.outcome.slip_m);
  EXPECT_EQ(a.outcome.turn_rad, b.outcome.turn_rad);
  EXPECT_EQ(a.outcome.disturbed, b.outcome.disturbed);
  EXPECT_EQ(a.outcome.is_target, b.outcome.is_target);
  EXPECT_EQ(a.outcome.parts_touched, b.outcome.parts_touched);
  EXPECT_EQ(a.outcome.parts_risen, b.outcome.parts_risen);
  EXPECT_EQ(a.outcome.lift_height_m, b.outcome.lift_height_m);
  EXPECT_EQ(a.outcome.contact_force_n, b.outcome.contact_force_n);
  EXPECT_EQ(a.outcome.contact_torque_nm, b.outcome.contact_torque_nm);
  EXPECT_EQ(a.outcome.retreat_contact, b.outcome.retreat_contact);
  EXPECT_EQ(a.outcome.retreat_opening, b.outcome.retreat_opening);
  EXPECT_EQ(a.outcome.set_down, b.outcome.set_down);
  EXPECT_EQ(a.outcome.place_error_m, b.outcome.place_error_m);
  EXPECT_EQ(a.outcome.place_turn_rad, b.outcome.place_turn_rad);
  EXPECT_EQ(a.outcome.verdicts, b.outcome.verdicts);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (size_t i = 0; i < a.instances.size(); ++i) {
    EXPECT_EQ(a.instances[i].instance, b.instances[i].instance);
    EXPECT_EQ(a.instances[i].object, b.instances[i].object);
    EXPECT_EQ(a.instances[i].visible_fraction, b.instances[i].visible_fraction);
    EXPECT_EQ(a.instances[i].recalled, b.instances[i].recalled);
    EXPECT_EQ(a.instances[i].missed, b.instances[i].missed);
  }
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (size_t i = 0; i < a.hypotheses.size(); ++i) {
    const HypothesisScore &x = a.hypotheses[i], &y = b.hypotheses[i];
    EXPECT_EQ(std::tie(x.object, x.instance, x.score, x.mssd_m, x.mspd_px, x.add_m, x.adi_m),
              std::tie(y.object, y.instance, y.score, y.mssd_m, y.mspd_px, y.add_m, y.adi_m));
    EXPECT_EQ(std::tie(x.rotation_rad, x.translation_m, x.mssd_diameters, x.correct),
              std::tie(y.rotation_rad, y.translation_m, y.mssd_diameters, y.correct));
    EXPECT_EQ(x.X_WO.matrix(), y.X_WO.matrix());
    EXPECT_EQ(x.X_OtrueObelieved.matrix(), y.X_OtrueObelieved.matrix());
  }
}

void ExpectSameTrial(const TrialResult& a, const TrialResult& b) {
  EXPECT_EQ(a.trial, b.trial);
  EXPECT_EQ(a.parts_dropped, b.parts_dropped);
  EXPECT_EQ(a.parts_cleared, b.parts_cleared);
  EXPECT_EQ(a.ended_by, b.ended_by);
  EXPECT_EQ(a.certificate.at_rest, b.certificate.at_rest);
  EXPECT_EQ(a.certificate.simulated_s, b.certificate.simulated_s);
  EXPECT_EQ(a.certificate.max_speed_mps, b.certificate.max_speed_mps);
  EXPECT_EQ(a.certificate.max_spin_radps, b.certificate.max_spin_radps);
  EXPECT_EQ(a.certificate.deepest_penetration_m, b.certificate.deepest_penetration_m);
  EXPECT_EQ(a.certificate.wake_movement_m, b.certificate.wake_movement_m);
  EXPECT_EQ(a.certificate.wake_movement_diameters, b.certificate.wake_movement_diameters);
  ASSERT_EQ(a.refused.size(), b.refused.size());
  for (size_t i = 0; i < a.refused.size(); ++i) {
    EXPECT_EQ(a.refused[i].attempt, b.refused[i].attempt);
    EXPECT_EQ(a.refused[i].faults, b.refused[i].faults);
  }
  ASSERT_EQ(a.fates.size(), b.fates.size());
  for (size_t i = 0; i < a.fates.size(); ++i) {
    const InstanceFate &x = a.fates[i], &y = b.fates[i];
    EXPECT_EQ(std::tie(x.instance, x.object, x.picked, x.asked, x.loss, x.pick),
              std::tie(y.instance, y.object, y.picked, y.asked, y.loss, y.pick));
  }
  EXPECT_EQ(a.seconds, b.seconds);
  ASSERT_EQ(a.picks.size(), b.picks.size());
  for (size_t i = 0; i < a.picks.size(); ++i) ExpectSamePick(a.picks[i], b.picks[i]);
}

TEST_F(ResultsStoreTest, ReadsBackEveryBitOfATrial) {
  ResultsStore(folder_, "seed: 1").Write(FullTrial(4));
  const auto read = ResultsStore(folder_, "seed: 1").ReadAll();
  ASSERT_EQ(read.size(), 1u);
  ExpectSameTrial(read[0], FullTrial(4));
}

TEST_F(ResultsStoreTest, TellsWhatItWasWrittenWith) {
  EXPECT_FALSE(StoredSettings(folder_).has_value());
  EXPECT_TRUE(std::filesystem::is_empty(folder_)) << "asking makes no file";
  ResultsStore(folder_, "seed: 1").Write(FullTrial(4));
  EXPECT_EQ(StoredSettings(folder_), "seed: 1");
}

TEST_F(ResultsStoreTest, OrderOfWritingDoesNotMatter) {
  ResultsStore store(folder_, "s");
  for (int trial : {5, 0, 3}) store.Write(FullTrial(trial));
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(0, 3, 5));
  const auto read = store.ReadAll();
  ASSERT_EQ(read.size(), 3u);
  const int expected[] = {0, 3, 5};
  for (int i = 0; i < 3; ++i) ExpectSameTrial(read[i], FullTrial(expected[i]));
}

TEST_F(ResultsStoreTest, RefusesResultsOfOtherSettings) {
  ResultsStore(folder_, "seed: 1").Write(FullTrial(0));
  const std::string error = ErrorOf([&] { ResultsStore(folder_, "seed: 2"); });
  EXPECT_THAT(error, HasSubstr(folder_.string()));
  EXPECT_THAT(error, HasSubstr("--out"));
}

// A store of before the rules of success stood beside each other lacks their columns.
TEST_F(ResultsStoreTest, AStoreOfAnEarlierVersionIsRefusedInOneLine) {
  ResultsStore(folder_, "s").Write(FullTrial(0));
  const auto file = folder_ / "results.sqlite";
  std::string bytes = ReadFileBytes(file);
  const std::string key = "schema_version";
  const size_t at = bytes.find(key);
  ASSERT_NE(at, std::string::npos);
  bytes[at + key.size()] = '0';
  std::ofstream(file, std::ios::binary) << bytes;
  const std::string error = ErrorOf([&] { ResultsStore(folder_, "s"); });
  EXPECT_THAT(error, HasSubstr("written by another version of pickbed (schema 0, here "));
  EXPECT_THAT(error, HasSubstr("--out"));
  EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 0);
}

TEST_F(ResultsStoreTest, WithoutATrialItTakesNewSettings) {
  ResultsStore(folder_, "seed: 1");
  ResultsStore(folder_, "seed: 2").Write(FullTrial(0));
  EXPECT_EQ(ResultsStore(folder_, "seed: 2").ReadAll().size(), 1u);
  EXPECT_NE(ErrorOf([&] { ResultsStore(folder_, "seed: 1"); }), "");
}

TEST_F(ResultsStoreTest, SecondWriteOfATrialFailsAndKeepsTheFirst) {
  ResultsStore store(folder_, "s");
  store.Write(FullTrial(0));
  TrialResult other = FullTrial(0);
  other.parts_dropped = 99;
  EXPECT_THROW(store.Write(other), std::runtime_error);
  const auto read = store.ReadAll();
  ASSERT_EQ(read.size(), 1u);
  ExpectSameTrial(read[0], FullTrial(0));
}

TEST_F(ResultsStoreTest, TellsWhenTheFolderCannotBeMadeOrTheFileIsForeign) {
  const auto file = folder_ / "file";
  std::ofstream(file) << "no folder";
  EXPECT_THAT(ErrorOf([&] { ResultsStore(file, "s"); }), HasSubstr("--out"));
  std::ofstream(folder_ / "results.sqlite") << std::string(4096, 'x');
  EXPECT_THAT(ErrorOf([&] { ResultsStore(folder_, "s"); }), HasSubstr("results.sqlite"));
}

// Starts processes that wait for each other and then write to one new file at once; returns how
// many of them failed.
int FailuresOfWriters(const std::filesystem::path& folder, int processes, int trials_each) {
  int gate[2];
  EXPECT_EQ(pipe(gate), 0);
  std::vector<pid_t> children;
  for (int process = 0; process < processes; ++process) {
    const pid_t child = fork();
    if (child == 0) {
      close(gate[1]);
      char nothing;
      if (read(gate[0], &nothing, 1) != 0) _exit(2);  // returns when the parent closes its end
      try {
        ResultsStore store(folder, "s");
        for (int i = 0; i < trials_each; ++i) store.Write(FullTrial(process + i * processes));
      } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        _exit(1);
      }
      _exit(0);
    }
    children.push_back(child);
  }
  close(gate[0]);
  close(gate[1]);
  int failures = 0;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    failures += status != 0;
  }
  return failures;
}

TEST_F(ResultsStoreTest, SeveralProcessesWriteToOneFile) {
  constexpr int kProcesses = 8, kTrialsEach = 5;
  EXPECT_EQ(FailuresOfWriters(folder_, kProcesses, kTrialsEach), 0);
  const auto read = ResultsStore(folder_, "s").ReadAll();
  ASSERT_EQ(read.size(), static_cast<size_t>(kProcesses * kTrialsEach));
  for (size_t i = 0; i < read.size(); ++i) ExpectSameTrial(read[i], FullTrial(i));
}

TEST_F(ResultsStoreTest, SeveralProcessesMayOpenANewFileAtOnce) {
  constexpr int kTimes = 20, kProcesses = 8;  // in WAL mode one time in eight failed
  for (int i = 0; i < kTimes; ++i) {
    ASSERT_EQ(FailuresOfWriters(folder_ / std::to_string(i), kProcesses, 1), 0);
  }
}

TEST_F(ResultsStoreTest, AKilledWriterLosesOnlyWhatWasInFlight) {
  const pid_t child = fork();
  if (child == 0) {
    ResultsStore store(folder_, "s");
    store.Write(FullTrial(0));
    store.Write(FullTrial(1));
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  EXPECT_THAT(ResultsStore(folder_, "s").FinishedTrials(), ElementsAre(0, 1));
}

}  // namespace
}  // namespace pickbed
