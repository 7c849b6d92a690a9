#include "eval/store/store_check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "eval/store/results_store.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/full_trial.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

class StoreCheck : public testing::Test {
 protected:
  StoreCheck() {
    ResultsStore store(temporary_.path(), "seed: 1");
    for (int trial = 0; trial < 3; ++trial) store.Write(FullTrial(trial));
  }
  void Edit(const std::string& sql) const {
    Database(temporary_.path() / kStoreFile, Database::Mode::kExisting).Execute(sql);
  }
  // Returns the message, empty = the store is accepted.
  std::string ErrorAtReading() const {
    return Refusal([&] { ResultsStore::OpenToRead(temporary_.path()).ReadAll(); });
  }
  std::string ErrorAtResuming() const {
    return Refusal([&] { ResultsStore(temporary_.path(), "seed: 1").ReadAll(); });
  }
  static std::string Refusal(const std::function<void()>& read) {
    try {
      read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  const TemporaryFolder temporary_;
};

TEST_F(StoreCheck, AcceptsWhatThisProgramWrote) {
  EXPECT_EQ(ErrorAtReading(), "");
  EXPECT_EQ(ErrorAtResuming(), "");
}

struct EditedStore {
  const char* sql;
  const char* message;
};

class EditedStores : public StoreCheck, public testing::WithParamInterface<EditedStore> {};

TEST_P(EditedStores, AreRefusedWithTableAndRow) {
  Edit(GetParam().sql);
  for (const std::string& error : {ErrorAtReading(), ErrorAtResuming()}) {
    EXPECT_THAT(error, HasSubstr("results.sqlite: "));
    EXPECT_THAT(error, HasSubstr(GetParam().message));
    EXPECT_THAT(error, HasSubstr("restore the file from a copy"));
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, EditedStores,
    testing::Values(
        EditedStore{"DELETE FROM attempts", "has no such attempt"},
        EditedStore{"UPDATE settings SET value = x'00ff'", "table 'settings', row"},
        EditedStore{"DELETE FROM attempts WHERE trial = 1 AND attempt = 0", "have a gap"},
        EditedStore{"UPDATE hypotheses SET attempt = 100000",
                    "table 'hypotheses', trial 0: table 'attempts' has no such attempt"},
        EditedStore{"UPDATE hypotheses SET attempt = -1", "has no such attempt"},
        EditedStore{"UPDATE instances SET attempt = -1", "table 'instances'"},
        EditedStore{"UPDATE rejections SET attempt = 99", "table 'rejections'"},
        EditedStore{"UPDATE hypothesis_metrics SET hypothesis = 99", "table 'hypothesis_metrics'"},
        EditedStore{"UPDATE attempts SET grasp_x_wg = '[]'",
                    "column 'grasp_x_wg': '[]' is no list of 12 numbers"},
        EditedStore{"UPDATE attempts SET grasp_x_wg = '[1]'", "'[1]' is no list of 12 numbers"},
        EditedStore{"UPDATE attempts SET grasp_x_wg = '[[[[1'", "is no list of numbers"},
        EditedStore{"UPDATE attempts SET grasp_x_wg = '[1,0,0,0,0,1,0,0,0,0,\"1\",0]'",
                    "is no list of numbers"},
        EditedStore{"UPDATE attempts SET grasp_x_wg = '[2,0,0,0,0,1,0,0,0,0,1,0]'",
                    "rotation is not orthonormal"},
        EditedStore{"UPDATE attempts SET grasp_x_wg = '[1,0,0,0,0,1,0,0,0,0,-1,0]'",
                    "rotation is not orthonormal"},
        EditedStore{"UPDATE attempts SET chosen_hypothesis = 77",
                    "the chosen hypothesis does not exist"},
        EditedStore{"UPDATE attempts SET chosen_hypothesis = 'x'",
                    "column 'chosen_hypothesis': 'x' is no integer"},
        EditedStore{"UPDATE attempts SET pick_of_image = 9000000000",
                    "is not from 0 to 2147483647"},
        EditedStore{"UPDATE attempts SET executed = 3", "'3' is neither 0 nor 1"},
        EditedStore{"UPDATE attempts SET failure = 'bad luck'",
                    "column 'failure': 'bad luck' is no failure reason"},
        EditedStore{"UPDATE attempts SET grasp_score = 'high'", "'high' is no number"},
        EditedStore{"UPDATE attempts SET hash_scene = '12x'", "'12x' is no unsigned integer"},
        EditedStore{"UPDATE instances SET visible_fraction = 7", "visible fraction"},
        EditedStore{"UPDATE instances SET object = -2", "is negative"},
        EditedStore{"UPDATE trials SET configuration = 5",
                    "table 'trials', row 1: table 'configurations' has no such configuration"},
        EditedStore{"UPDATE configurations SET first_trial = 2147483647, trials = 3",
                    "table 'configurations', row 1: its trials are not between 0 and 1000000000"},
        EditedStore{"UPDATE configurations SET first_trial = -1",
                    "table 'configurations', row 1: its trials are not between 0 and 1000000000"},
        EditedStore{"UPDATE trials SET trial = 2147483647 WHERE trial = 2",
                    "table 'trials', row 3: the number of the trial is missing, negative or too"},
        EditedStore{"UPDATE rejections SET grasps = -1 WHERE rowid = 2",
                    "table 'rejections', row 2: the value in column 'grasps' is not from 0 to"},
        EditedStore{"UPDATE trials SET simulated_s = -11 WHERE rowid = 2",
                    "table 'trials', row 2: the value in column 'simulated_s' is not from 0 to"},
        EditedStore{"UPDATE trials SET bin_z_m = 2147483648",
                    "the value in column 'bin_z_m' is not from -1000 to 1000"},
        EditedStore{"UPDATE attempts SET neighbors_displaced = -1 WHERE rowid = 1",
                    "table 'attempts', row 1: the value in column 'neighbors_displaced' is not"},
        EditedStore{"UPDATE attempts SET picked_instance = -2 WHERE rowid = 1",
                    "row 1: the value in column 'picked_instance' is not from -1 to"},
        EditedStore{"UPDATE trials SET bin_index = -1 WHERE rowid = 3",
                    "table 'trials', row 3: the value in column 'bin_index' is not from 0 to"},
        EditedStore{"UPDATE instance_outcomes SET mass_deviation = -40 WHERE rowid = 2",
                    "trial 0: in table 'instance_outcomes', a deviation is under -1"},
        EditedStore{"UPDATE instance_outcomes SET instance = -1 WHERE rowid = 2",
                    "the number of an instance or attempt is negative"},
        EditedStore{"UPDATE hypotheses SET instance = -2 WHERE rowid = 1",
                    "attempt 0: the object or instance of a hypothesis is negative"},
        EditedStore{"UPDATE trials SET instances_graspable = 99",
                    "more instances are graspable than were tested"},
        EditedStore{"UPDATE trials SET status = 'lost'", "neither finished nor crashed"},
        EditedStore{"UPDATE trials SET crash = 'x' WHERE rowid = 1",
                    "table 'trials', row 1: it is finished and names a crash"},
        EditedStore{"UPDATE trials SET layers = x'00'", "is a BLOB"},
        EditedStore{"UPDATE hypothesis_metrics SET metric = CAST(x'6dff' AS TEXT) WHERE rowid = 1",
                    "is not UTF-8"},
        EditedStore{"UPDATE rejections SET cause = CAST(x'63a5' AS TEXT) WHERE rowid = 1",
                    "table 'rejections', row 1: column 'cause': 'c\\xa5' is not UTF-8"},
        EditedStore{"UPDATE configurations SET name = CAST(x'a5' AS TEXT)",
                    "table 'configurations', row 1: column 'name': '\\xa5' is not UTF-8"},
        EditedStore{"UPDATE rejections SET cause = CAST(x'6300' AS TEXT) WHERE rowid = 1",
                    "column 'cause': 'c' continues after a zero byte"},
        EditedStore{"UPDATE trials SET trial = 7 WHERE trial = 2",
                    "table 'attempts', row 7: table 'trials' has no such finished trial"},
        EditedStore{"UPDATE trials SET trial = -1 WHERE trial = 0",
                    "table 'trials', row 1: the number of the trial is missing, negative or too"},
        EditedStore{"UPDATE instances SET trial = -1 WHERE rowid = 1",
                    "table 'instances', row 1: table 'trials' has no such finished trial"},
        EditedStore{"UPDATE timings SET trial = NULL WHERE rowid = 2",
                    "table 'timings', row 2: table 'trials' has no such finished trial"},
        EditedStore{"UPDATE rejections SET trial = 3 WHERE rowid = 1",
                    "table 'rejections', row 1: table 'trials' has no such finished trial"},
        EditedStore{"INSERT INTO bands SELECT * FROM bands WHERE rowid = 3",
                    "table 'bands', trial 1: band 0 is there twice"},
        EditedStore{"UPDATE bands SET band = 5 WHERE rowid = 2",
                    "table 'bands', trial 0: band 5 is not the next one"},
        EditedStore{"UPDATE bands SET band = -1 WHERE rowid = 1", "band -1 is not the next one"},
        EditedStore{"UPDATE timings SET stage = 'lunch' WHERE rowid = 3",
                    "table 'timings', trial 1: column 'stage': 'lunch' is no stage of a trial"},
        EditedStore{"UPDATE timings SET stage = '-1'", "'-1' is no stage of a trial"},
        EditedStore{"UPDATE timings SET stage = 'estimate/'", "'estimate/' is no stage"},
        EditedStore{"UPDATE timings SET seconds = -1 WHERE rowid = 1",
                    "column 'seconds': -1 is no duration of stage 'capture'"},
        EditedStore{"INSERT INTO timings SELECT * FROM timings WHERE rowid = 4",
                    "table 'timings', trial 1: stage 'drop' is there twice"},
        EditedStore{"INSERT INTO timings SELECT trial, 'see', 1 FROM timings WHERE rowid = 1",
                    "stage 'see' is there twice"},
        EditedStore{"INSERT INTO instances SELECT * FROM instances WHERE rowid = 1",
                    "attempt 0: in table 'instances', instance 0 is there twice"},
        EditedStore{"INSERT INTO rejections SELECT * FROM rejections WHERE rowid = 1",
                    "table 'rejections', trial 0: attempt 0 has the cause 'collision' twice"},
        EditedStore{"INSERT INTO refusals SELECT * FROM refusals WHERE rowid = 3",
                    "table 'refusals', trial 0: drop 1 has the fault 'fell outside' twice"},
        EditedStore{"INSERT INTO refusals SELECT * FROM refusals WHERE rowid = 1",
                    "table 'refusals', trial 0: drop 0 is not the next one"},
        EditedStore{"UPDATE refusals SET attempt = 7 WHERE rowid = 3",
                    "table 'refusals', trial 0: drop 7 is not the next one"},
        EditedStore{"INSERT INTO instance_outcomes SELECT * FROM instance_outcomes WHERE rowid = 2",
                    "trial 0: in table 'instance_outcomes', instance 1 is there twice"},
        EditedStore{"UPDATE instance_outcomes SET instance = 1 WHERE rowid = 1",
                    "trial 0: in table 'instance_outcomes', instance 1 is two objects"},
        EditedStore{"DELETE FROM settings WHERE key = 'schema_version'",
                    "table 'settings', row 'schema_version': it is missing"},
        EditedStore{"UPDATE attempts SET physical_failure = 'slipped', slip_m = NULL",
                    "table 'attempts', row 1: column 'slip_m': 'NULL' is no number"},
        EditedStore{"UPDATE hypotheses SET score = NULL WHERE rowid = 2",
                    "table 'hypotheses', row 2: column 'score': 'NULL' is no number"},
        EditedStore{"UPDATE hypothesis_metrics SET value = NULL WHERE rowid = 4",
                    "table 'hypothesis_metrics', row 4: column 'value': 'NULL' is no number"},
        EditedStore{"UPDATE instances SET visible_fraction = NULL WHERE rowid = 5",
                    "table 'instances', row 5: column 'visible_fraction': 'NULL' is no number"},
        EditedStore{"UPDATE trials SET simulated_s = NULL", "column 'simulated_s': 'NULL'"},
        EditedStore{"UPDATE timings SET seconds = NULL", "column 'seconds': 'NULL' is no number"},
        EditedStore{"UPDATE attempts SET failure = NULL", "column 'failure': 'NULL' is no text"},
        EditedStore{"UPDATE rejections SET cause = NULL", "column 'cause': 'NULL' is no text"},
        EditedStore{
            "INSERT INTO hypothesis_metrics SELECT * FROM hypothesis_metrics WHERE rowid = 1",
            "has the metric 'mssd_m' of hypothesis 0 twice"},
        EditedStore{"DELETE FROM rejections WHERE rowid = 1",
                    "table 'trials', trial 0: the other tables have "},
        EditedStore{"DELETE FROM refusals WHERE rowid = 2",
                    "table 'trials', trial 0: the other tables have "},
        EditedStore{"DELETE FROM instance_outcomes WHERE trial = 2",
                    "table 'trials', trial 2: the other tables have "},
        EditedStore{"DELETE FROM instances WHERE trial = 1 AND attempt = 0",
                    "table 'trials', trial 1: the other tables have "},
        EditedStore{"UPDATE trials SET child_rows = child_rows + 1 WHERE trial = 1",
                    "table 'trials', trial 1: the other tables have "},
        EditedStore{"DELETE FROM configurations", "has no such configuration"},
        EditedStore{"ALTER TABLE attempts DROP COLUMN slip_m",
                    "table 'attempts' has no column 'slip_m'"},
        EditedStore{"DROP TABLE hypotheses", "table 'hypotheses' has no column 'trial'"}));

TEST(StoreCheckOfSweeps, ANameThatTheSettingsDoNotHaveIsRefused) {
  const TemporaryFolder temporary;
  StoreHead head;
  head.configurations = {{0, "seed=5", 0, 1, 5, "a", "seed: 5"},
                         {1, "seed=6", 1, 1, 6, "b", "seed: 6"},
                         {2, "cycle.move_s=2", 2, 1, 6, "b", "seed: 6"}};
  head.identity = SweepIdentity(head.configurations);
  ResultsStore(temporary.path(), head).Write(FullTrial(0));
  EXPECT_NO_THROW(ResultsStore::OpenToRead(temporary.path()));
  const auto rename = [&](const std::string& name) {
    Database(temporary.path() / kStoreFile, Database::Mode::kExisting)
        .Execute("UPDATE configurations SET name = '" + name + "' WHERE configuration = 0");
  };
  rename("folder:seed=5");  // as in a merged store
  EXPECT_NO_THROW(ResultsStore::OpenToRead(temporary.path()));
  for (const char* name : {"seed=-", "xseed=5", "seed=6"}) {
    rename(name);
    try {
      ResultsStore::OpenToRead(temporary.path());
      FAIL() << name;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("table 'configurations', configuration 0"));
      EXPECT_THAT(error.what(), HasSubstr(fmt::format("another name than '{}'", name)));
    }
  }
}

// A merge copies rows unread.
TEST_F(StoreCheck, RowsAreCheckedTogetherBeforeTheyAreCopied) {
  const auto error = [&] {
    return Refusal([&] { ResultsStore::OpenToRead(temporary_.path(), StoreChecks::kRows); });
  };
  EXPECT_EQ(error(), "");
  Edit("UPDATE trials SET child_rows = child_rows + 1 WHERE trial = 1");
  EXPECT_THAT(error(), HasSubstr("table 'trials', row 2: the other tables have too few"));
  Edit("UPDATE hypothesis_metrics SET hypothesis = 99 WHERE rowid = 1");
  EXPECT_THAT(error(), HasSubstr("table 'hypothesis_metrics', row 1: table 'hypotheses' has no"));
  Edit("UPDATE hypotheses SET attempt = 7 WHERE rowid = 2");
  EXPECT_THAT(error(),
              HasSubstr("table 'hypotheses', row 2: table 'attempts' has no such attempt"));
  Edit("DELETE FROM trials WHERE trial = 1");
  EXPECT_THAT(error(), HasSubstr("table 'trials' has no such trial"));
}

// SQLite stores NaN as NULL.
TEST_F(StoreCheck, AnAttemptWhosePhysicsFailedMayLackNumbers) {
  Edit("UPDATE attempts SET physical_failure = 'physics_failed', slip_m = NULL WHERE rowid = 1");
  EXPECT_EQ(ErrorAtReading(), "");
  const std::vector<TrialResult> results = ResultsStore::OpenToRead(temporary_.path()).ReadAll();
  EXPECT_EQ(results[0].attempts[0].outcome.slip_m, 0);
  EXPECT_NE(results[0].attempts[1].outcome.slip_m, 0);
  Edit("UPDATE attempts SET executed = NULL WHERE rowid = 1");
  EXPECT_THAT(ErrorAtReading(), HasSubstr("column 'executed': 'NULL' is neither 0 nor 1"));
}

TEST_F(StoreCheck, StagesOfEstimatorsAndFormerNamesAreAccepted) {
  Edit(
      "INSERT INTO timings VALUES (0, 'estimate/of_another_estimator', 0), (0, 'not_finite/depth', "
      "7), (1, 'try', 0.5)");
  Edit("UPDATE timings SET stage = 'see' WHERE stage = 'capture'");
  EXPECT_EQ(ErrorAtReading(), "");
  EXPECT_EQ(Refusal([&] { ResultsStore::OpenToRead(temporary_.path(), StoreChecks::kRows); }), "");
}

TEST_F(StoreCheck, DoubledRowsAreRefusedBeforeTheyAreCopied) {
  struct {
    std::string table, message;
  } const cases[] = {
      {"bands", "the numbers in column 'band' of its trial have a gap"},
      {"timings", "another row has the same trial, stage"},
      {"instances", "another row has the same trial, attempt, instance"},
      {"rejections", "another row has the same trial, attempt, cause"},
      {"refusals", "another row has the same trial, attempt, fault"},
      {"instance_outcomes", "another row has the same trial, instance, attempt"},
      {"hypothesis_metrics", "another row has the same trial, attempt, hypothesis, metric"},
  };
  const auto error = [&] {
    return Refusal([&] { ResultsStore::OpenToRead(temporary_.path(), StoreChecks::kRows); });
  };
  for (const auto& test : cases) {
    Edit(fmt::format("INSERT INTO {0} SELECT * FROM {0} WHERE rowid = 1", test.table));
    EXPECT_THAT(error(), HasSubstr(fmt::format("table '{}', row ", test.table)));
    EXPECT_THAT(error(), HasSubstr(test.message));
    Edit(fmt::format("DELETE FROM {0} WHERE rowid = (SELECT max(rowid) FROM {0})", test.table));
    EXPECT_EQ(error(), "");
  }
  Edit("UPDATE refusals SET attempt = 3 WHERE rowid = 3");
  EXPECT_THAT(error(), HasSubstr("table 'refusals', row 1: the numbers in column 'attempt' of its "
                                 "trial have a gap"));
  Edit("UPDATE refusals SET attempt = 1 WHERE rowid = 3");
  Edit("UPDATE timings SET stage = 'lunch' WHERE rowid = 3");
  EXPECT_THAT(error(), HasSubstr("table 'timings', trial 1: column 'stage': 'lunch' is no stage"));
  Edit("UPDATE timings SET seconds = -2 WHERE rowid = 5");
  EXPECT_THAT(error(), HasSubstr("table 'timings', row 5: its duration is negative"));
}

// A damaged page that SQLite does not notice when it reads the rows.
TEST_F(StoreCheck, DamagedPagesAreRefused) {
  const std::filesystem::path file = temporary_.path() / kStoreFile;
  const std::string bytes = ReadFileBytes(file);
  int refused = 0, silent = 0;
  for (size_t at = 4096; at < bytes.size(); at += 4096) {
    std::string damaged = bytes;
    for (size_t i = 0; i < 16; ++i) damaged[at + i] ^= 0x5a;  // head of a page
    WriteFileAtomically(file, damaged);
    const std::string error = ErrorAtReading();
    refused += !error.empty();
    silent += error.empty();
    EXPECT_TRUE(error.empty() || error.find("results.sqlite") != std::string::npos) << error;
  }
  EXPECT_GT(refused, 0);
  EXPECT_EQ(silent, 0);
}

// A trial of two attempts, one of which cleared an instance, in a bin of two objects.
TrialResult SoundTrial() {
  TrialResult trial;
  trial.trial = 4;
  trial.instances_cleared = 1;
  trial.attempts.resize(2);
  trial.attempts[0].grasp = Grasp();
  trial.attempts[0].band = 2;
  trial.attempts[1].attempt = 1;
  trial.attempts[1].failure = FailureReason::kNoGrasp;
  trial.outcomes = {{InstanceId{0}, ObjectId{1}}};
  return trial;
}

TEST(CheckTrial, AcceptsASoundTrial) {
  EXPECT_NO_THROW(CheckTrial(SoundTrial(), {2, 3}, "a.sqlite"));
}

TEST(CheckTrial, RefusesWhatDisagreesWithTheSettingsOrWithItself) {
  const auto error = [](const std::function<void(TrialResult&)>& edit) {
    TrialResult trial = SoundTrial();
    edit(trial);
    return ErrorOf([&] { CheckTrial(trial, {2, 3}, "a.sqlite"); });
  };
  EXPECT_THAT(error([](TrialResult& t) { t.instances_cleared = 2; }),
              HasSubstr("a.sqlite: table 'trials', trial 4: 1 attempts succeeded, but column "
                        "'instances_cleared' is 2; "));
  EXPECT_THAT(error([](TrialResult& t) { t.attempts[0].failure = FailureReason::kSlipped; }),
              HasSubstr("0 attempts succeeded"));
  EXPECT_THAT(error([](TrialResult& t) { t.attempts[1].failure = FailureReason::kNone; }),
              HasSubstr("table 'attempts', trial 4: attempt 1 has neither a grasp nor a failure"));
  EXPECT_THAT(error([](TrialResult& t) { t.attempts[0].band = 3; }),
              HasSubstr("table 'attempts', trial 4: the settings have no band 3"));
  EXPECT_THAT(error([](TrialResult& t) { t.outcomes[0].object = ObjectId{2}; }),
              HasSubstr("table 'instance_outcomes', trial 4: the settings have no object 2"));
}

}  // namespace
}  // namespace pickbed::tests
