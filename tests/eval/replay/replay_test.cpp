#include "eval/replay/replay.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>

#include "eval/replay/first_difference.h"
#include "eval/replay/stage_files.h"
#include "eval/sweep/run.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/scenario/load_objects.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kTrial = 1;

// A results folder with two trials of two small cubes. The mesh is a file next to the folder.
class ReplayTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(run_);
    SaveCube(0.03);
    const std::string settings =
        "seed: 3\ntrials: 2\n"
        "objects:\n  - {name: cube, count: 2, mesh: ../cube.obj, mass_kg: 0.05}\n"
        "sensor: structured_light\n"
        "estimator: {name: oracle, noise_mm: 2}\n";
    ScenarioSpec spec = LoadScenarioText(settings, run_, "test");
    const std::string effective = WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
    const ObjectSet objects = LoadObjects(spec, ObjectCatalog({}));
    StoredConfiguration point;
    point.trials = 2;
    point.seed = spec.seed;
    point.settings = effective;
    point.identity = RunIdentity(spec, objects);
    ResultsStore store(run_, StoreHead{point.identity, {point}});
    TrialRunner runner(spec, objects);
    for (int trial = 0; trial < 2; ++trial) store.Write(runner.Run(BinIndex(trial)));
  }

  void SaveCube(double side_m) const {
    SaveObj(folder_.path() / "cube.obj", Cube(side_m, 0.05, 0.5)->mesh_O);
  }
  // Changes the store directly, without the program.
  void Sql(const std::string& sql) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((run_ / "results.sqlite").c_str(), &db), SQLITE_OK);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    EXPECT_GT(sqlite3_changes(db), 0) << "no row changed by " << sql;
    sqlite3_close(db);
  }
  // Keep() saves the store before a change, and Restore() brings it back.
  void Keep() const { std::filesystem::copy(run_ / "results.sqlite", run_ / "kept"); }
  void Restore() const { std::filesystem::rename(run_ / "kept", run_ / "results.sqlite"); }
  RecordedTrial Record() const { return ReadRecordedTrial({run_, kTrial}, "no_catalog"); }
  ReplayReport Replay() const { return ReplayTrial(Record(), nullptr, {}); }
  std::string RefusalOf(const TrialAddress& address) const {
    return ErrorOf([&] { ReadRecordedTrial(address, "no_catalog"); });
  }

  const TemporaryFolder folder_;
  const std::filesystem::path run_ = folder_.path() / "run";
};

// Attempt and stage of the first difference, such as "0 grasp", or "none".
std::string FirstDifference(const ReplayReport& report) {
  const StageReplay* first = report.FirstDifference();
  return first ? fmt::format("{} {}", first->attempt, StageName(first->stage)) : "none";
}

TEST_F(ReplayTest, AllStagesOfAllAttemptsAreIdentical) {
  const RecordedTrial record = Record();
  EXPECT_THAT(record.changes, IsEmpty());
  ASSERT_GE(record.result.attempts.size(), 2u);
  const ReplayReport report = ReplayTrial(record, nullptr, {});
  EXPECT_EQ(FirstDifference(report), "none");
  EXPECT_EQ(report.stages.size(), 5 * record.result.attempts.size());
  for (const StageReplay& row : report.stages) {
    EXPECT_EQ(row.verdict, ReplayVerdict::kSame);
    EXPECT_NE(row.recorded, 0u);
  }
  const std::string table = ReplayTable(report);
  EXPECT_THAT(table, HasSubstr("all recorded stages are the same"));
  EXPECT_THAT(table, HasSubstr("attempt 0: 5 of 5 stages are the same\n"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'),
            static_cast<int>(record.result.attempts.size()) + 1)
      << "one line per attempt";
  const std::string verbose = ReplayTable(report, true);
  EXPECT_EQ(std::count(verbose.begin(), verbose.end(), '\n'),
            static_cast<int>(report.stages.size()) + 2);
}

TEST_F(ReplayTest, NamesTheStageThatASettingChanges) {
  struct Case {
    const char *before, *after, *stage;
  };
  for (const Case& c : {Case{"seed: 3", "seed: 4", "0 scene"},
                        {"friction: 0.5", "friction: 0.4", "0 scene"},
                        {"structured_light", "ideal", "0 image"},
                        {"noise_mm: 2", "noise_mm: 2.0000000001", "0 hypotheses"},
                        {"ranking: ", "ranking: random #", "0 grasp"}}) {
    SCOPED_TRACE(c.after);
    Keep();
    Sql(fmt::format("UPDATE configurations SET settings = replace(settings, '{}', '{}')", c.before,
                    c.after));
    const RecordedTrial record = Record();
    EXPECT_FALSE(record.changes.empty());
    EXPECT_EQ(FirstDifference(ReplayTrial(record, nullptr, {})), c.stage);
    Restore();
  }
  EXPECT_EQ(FirstDifference(Replay()), "none");
}

TEST_F(ReplayTest, NamesAChangedMeshAndTheChangedScene) {
  SaveCube(0.0301);
  const RecordedTrial record = Record();
  EXPECT_THAT(record.changes, ElementsAre("part cube: mesh or physical properties"));
  const ReplayReport report = ReplayTrial(record, nullptr, {});
  EXPECT_EQ(FirstDifference(report), "0 scene");
  EXPECT_FALSE(report.FirstDifference()->what.empty());
}

// For scenes and images, the record has only the visible instances and a hash.
TEST(WhatDiffers, NamesTheFirstDifferingInstance) {
  AttemptRecord recorded;
  recorded.instances = {{InstanceId{0}, ObjectId{0}, 0.5, true},
                        {InstanceId{1}, ObjectId{0}, 0.25, true}};
  AttemptRecord replayed = recorded;
  EXPECT_THAT(WhatDiffers(TrialStage::kScene, recorded, replayed), HasSubstr("only the hash"));
  EXPECT_THAT(WhatDiffers(TrialStage::kImage, recorded, replayed), HasSubstr("pixels"));
  replayed.instances[1].visible_fraction = 0.125;
  replayed.instances[0].recalled = false;  // belongs to a later stage
  for (const TrialStage stage : {TrialStage::kScene, TrialStage::kImage}) {
    EXPECT_EQ(WhatDiffers(stage, recorded, replayed),
              "instances[1].visible_fraction: 0.25 recorded, 0.125 replayed");
  }
  replayed.instances = {recorded.instances[0]};
  EXPECT_EQ(WhatDiffers(TrialStage::kScene, recorded, replayed),
            "instances: 2 recorded, 1 replayed");
}

TEST_F(ReplayTest, NamesAnAlteredRecord) {
  Sql(fmt::format(
      "UPDATE hypotheses SET score = score - 1e-15 WHERE trial = {} AND attempt = 1 AND "
      "hypothesis = 0",
      kTrial));
  const ReplayReport report = Replay();
  EXPECT_EQ(FirstDifference(report), "1 hypotheses");
  EXPECT_EQ(report.FirstDifference()->verdict, ReplayVerdict::kAltered);
  EXPECT_THAT(report.FirstDifference()->what, HasSubstr("hypotheses[0].score: "));
}

TEST_F(ReplayTest, NamesEachStageWithADifferentHash) {
  for (const char* stage : {"scene", "image", "hypotheses", "grasp", "outcome"}) {
    Keep();
    Sql(fmt::format("UPDATE attempts SET hash_{} = '7' WHERE trial = 1 AND attempt = 1", stage));
    EXPECT_EQ(FirstDifference(Replay()), fmt::format("1 {}", stage));
    Restore();
  }
}

TEST_F(ReplayTest, ReportsAttemptsThatOnlyOneRunHas) {
  const std::vector<AttemptRecord> whole = Record().result.attempts;
  const std::vector<AttemptRecord> shorter(whole.begin(), whole.end() - 1);
  ReplayReport report;
  report.stages = CompareStages(whole, shorter);
  EXPECT_EQ(FirstDifference(report), fmt::format("{} scene", shorter.size()));
  EXPECT_EQ(report.FirstDifference()->verdict, ReplayVerdict::kOnlyRecorded);
  report.stages = CompareStages(shorter, whole);
  EXPECT_EQ(report.FirstDifference()->verdict, ReplayVerdict::kOnlyReplayed);
}

// Stores of earlier versions have no hashes, only hypotheses, grasps and outcomes.
TEST_F(ReplayTest, RecordWithoutHashesIsComparedByItsValues) {
  Sql("UPDATE attempts SET hash_scene = '0', hash_image = '0', hash_hypotheses = '0', "
      "hash_grasp = '0', hash_outcome = '0'");
  const ReplayReport report = Replay();
  EXPECT_EQ(FirstDifference(report), "none");
  EXPECT_EQ(report.stages[0].verdict, ReplayVerdict::kNotRecorded);
  EXPECT_EQ(report.stages[2].verdict, ReplayVerdict::kSame);
  Sql("UPDATE attempts SET slip_m = slip_m + 1e-12 WHERE trial = 1 AND attempt = 0");
  EXPECT_EQ(FirstDifference(Replay()), "0 outcome");
  EXPECT_THAT(Replay().FirstDifference()->what, HasSubstr("slip_m: "));
}

TEST_F(ReplayTest, CrashedTrialIsReplayedFromItsNumber) {
  const StoreHead head = ResultsStore::OpenToRead(run_).head();
  ResultsStore(run_, head).WriteCrashed({2, 0, BinIndex{2}, 3, "ended by signal 11"});
  Sql("UPDATE configurations SET trials = 3");
  const RecordedTrial record = ReadRecordedTrial({run_, 2}, "no_catalog");
  ASSERT_TRUE(record.crashed.has_value());
  EXPECT_EQ(record.crashed->why, "ended by signal 11");
  const ReplayReport report = ReplayTrial(record, nullptr, {});
  EXPECT_EQ(FirstDifference(report), "none");
  EXPECT_GE(report.stages.size(), 5u);
  EXPECT_EQ(report.stages[0].verdict, ReplayVerdict::kNotRecorded);
  EXPECT_THAT(ReplayTable(report), HasSubstr("no stage was recorded to compare with"));
}

// Another person can have written the store, and with it the settings.
TEST_F(ReplayTest, ProgramsOfAStoreNeedPermission) {
  ScenarioSpec spec = Record().spec;
  RequireProgramsAllowed(spec, "run", false);
  spec.estimator.command = {"rm", "-rf", "x"};
  spec.planner.connect = "localhost:7000";
  EXPECT_THAT(ErrorOf([&] { RequireProgramsAllowed(spec, "run", false); }),
              HasSubstr("run: its settings use 'rm -rf x' and localhost:7000"));
  RequireProgramsAllowed(spec, "run", true);
}

TEST_F(ReplayTest, RefusesMissingTrialsAndFiles) {
  EXPECT_THAT(RefusalOf({folder_.path() / "nowhere", 0}), HasSubstr("there is no folder"));
  EXPECT_THAT(RefusalOf({folder_.path(), 0}), HasSubstr("results.sqlite"));
  EXPECT_THAT(RefusalOf({run_, 7}), HasSubstr("#7: the run has no such trial"));
  Sql("UPDATE configurations SET trials = 9");
  EXPECT_THAT(RefusalOf({run_, 7}), HasSubstr("#7: this trial is not finished"));
  std::filesystem::remove(folder_.path() / "cube.obj");
  EXPECT_THAT(RefusalOf({run_, 1}), testing::AllOf(HasSubstr("cannot be replayed"),
                                                   HasSubstr("cube.obj' does not exist")));
  Sql("UPDATE settings SET value = '99' WHERE key = 'schema_version'");
  EXPECT_THAT(RefusalOf({run_, 1}), HasSubstr("99"));
}

TEST_F(ReplayTest, ListsFinishedAndCrashedTrials) {
  {
    const StoreHead head = ResultsStore::OpenToRead(run_).head();
    ResultsStore(run_, head).WriteCrashed({4, 0, BinIndex(4), 3, "ended by signal 11"});
  }
  std::string expected = " trial   bin  attempts  successes  status\n";
  for (const TrialResult& trial : ResultsStore::OpenToRead(run_).ReadAll()) {
    int successes = 0;
    for (const AttemptRecord& attempt : trial.attempts) {
      successes += attempt.grasp && attempt.failure == FailureReason::kNone;
    }
    EXPECT_GT(successes, 0);
    expected += fmt::format("{:6}{:6}{:10}{:11}  finished\n", trial.trial, trial.trial,
                            trial.attempts.size(), successes);
  }
  EXPECT_EQ(TrialList(run_), expected + "     4     4         0          0  crashed\n");
  EXPECT_THAT(ErrorOf([&] { TrialList(folder_.path()); }), HasSubstr("has no results.sqlite"));
}

TEST_F(ReplayTest, DamagedTrialsAreRefusedWithTheirTable) {
  struct {
    std::string edit, message;
  } const cases[] = {
      {"UPDATE trials SET instances_cleared = 7 WHERE trial = 1", "table 'trials', trial 1: "},
      {"UPDATE attempts SET band = 9 WHERE trial = 1",
       "table 'attempts', trial 1: the settings have no band 9"},
      {"UPDATE instances SET object = 1 WHERE trial = 1",
       "table 'instances', trial 1: the settings have no object 1"},
  };
  const std::string list = TrialList(run_);
  for (const auto& test : cases) {
    Keep();
    Sql(test.edit);
    const std::string message = (run_ / kStoreFile).string() + ": " + test.message;
    const std::string error = RefusalOf({run_, 1});
    EXPECT_THAT(error, testing::StartsWith(message));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_THAT(TrialList(run_), HasSubstr("  damaged: " + error + "\n")) << "others are listed";
    EXPECT_EQ(std::ranges::count(TrialList(run_), '\n'), std::ranges::count(list, '\n'));
    EXPECT_EQ(RefusalOf({run_, 0}), "no error") << "this trial is sound";
    Restore();
  }
  EXPECT_EQ(TrialList(run_), list);
}

TEST(ParseTrialAddress, RequiresAFolderAndATrialNumber) {
  const TrialAddress address = ParseTrialAddress("results/a#b#12");
  EXPECT_EQ(address.run, "results/a#b");
  EXPECT_EQ(address.trial, 12);
  EXPECT_THAT(ErrorOf([] { ParseTrialAddress("results/demo"); }), HasSubstr("RUN#TRIAL"));
  for (const char* bad : {"demo#", "demo#x", "demo#1x", "demo#-1", "#3", "demo#99999999999"}) {
    EXPECT_THROW(ParseTrialAddress(bad), InputError) << bad;
  }
}

// Vertex positions of a binary PLY file.
std::vector<Eigen::Vector3f> PointsOf(const std::filesystem::path& file) {
  const std::string bytes = ReadFileBytes(file);
  constexpr size_t kBytesPerPoint = 15;
  std::vector<Eigen::Vector3f> points;
  for (size_t at = bytes.find("end_header\n") + 11; at < bytes.size(); at += kBytesPerPoint) {
    std::memcpy(points.emplace_back().data(), bytes.data() + at, 12);
  }
  return points;
}

TEST_F(ReplayTest, WritesTheFilesOfAllStages) {
  const RecordedTrial record = Record();
  const std::filesystem::path out = folder_.path() / "stages";
  StageFiles files(out);
  ReplayTrial(record, &files, {});
  for (size_t attempt = 0; attempt < record.result.attempts.size(); ++attempt) {
    for (const char* what : {"color.png", "depth.png", "depth_16bit.png", "ids.png", "overlay.png",
                             "after.png", "cloud.ply", "hypotheses.ply", "scene.glb"}) {
      EXPECT_TRUE(std::filesystem::exists(out / fmt::format("attempt_{:02}_{}", attempt, what)))
          << attempt << what;
    }
  }
  // The cubes are in the bin. The hypotheses and nearly all observed points must be there, too.
  const auto estimated = PointsOf(out / "attempt_00_hypotheses.ply");
  EXPECT_EQ(estimated.size(), 2u * StageFilesOptions().points_per_object);
  for (const Eigen::Vector3f& p_W : estimated) {
    EXPECT_LT(std::abs(p_W.x()), 0.23f);
    EXPECT_GT(p_W.z(), -0.02f);
    EXPECT_LT(p_W.z(), 0.1f);
  }
  const auto seen = PointsOf(out / "attempt_00_cloud.ply");
  EXPECT_GT(seen.size(), 10000u);
  const auto low = std::count_if(seen.begin(), seen.end(), [](const Eigen::Vector3f& p_W) {
    return p_W.z() > -0.05f && p_W.z() < 0.2f;
  });
  EXPECT_GT(low, 0.95 * seen.size());
}

}  // namespace
}  // namespace pickbed::tests
