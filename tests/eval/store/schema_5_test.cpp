#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "scenes/base/files.h"
#include "tests/eval/full_trial.h"
#include "tests/support/temporary_folder.h"

// Migration of schema 5, the version before most names changed. The tables are the ones of a file
// that this version wrote (tests/data/previous_version), and their rows have a value in every
// column.

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using Names = std::map<std::string, std::string>;  // in schema 5 -> now

const Names kTablesOf5{
    {"points", "configurations"}, {"picks", "attempts"}, {"fates", "instance_outcomes"}};
const Names kColumnsOf5{{"point", "configuration"},
                        {"scene", "bin_index"},
                        {"parts_dropped", "instances_dropped"},
                        {"parts_cleared", "instances_cleared"},
                        {"pick", "attempt"},
                        {"loss", "failure"},
                        {"aimed", "matched_instance"},
                        {"physical_loss", "physical_failure"},
                        {"parts_lifted", "instances_lifted"},
                        {"turn_rad", "in_hand_rotation_error_rad"},
                        {"disturbed", "neighbors_displaced"},
                        {"parts_touched", "instances_touched"},
                        {"parts_risen", "instances_risen"},
                        {"set_down", "place_executed"},
                        {"place_turn_rad", "place_rotation_error_rad"},
                        {"right_part", "right_instance"},
                        {"single_part", "single_instance"},
                        {"x_otrue_obelieved", "x_oe"}};
const Names kValuesOf5{{"wrong_part", "wrong_object"},
                       {"took_two", "double_pick"},
                       {"disturbed", "neighbor_displaced"},
                       {"see", "capture"},
                       {"palm meets a part", "palm meets an instance"}};
const std::set<std::string> kTextColumnsOf5{"ended_by", "loss",  "physical_loss",
                                            "missed",   "stage", "cause"};
const std::set<std::string> kMetricsOf5{"mssd_m",       "mspd_px",       "add_m",         "adi_m",
                                        "rotation_rad", "translation_m", "mssd_diameters"};

constexpr char kHeadOf5[] = "seed: 7\npolicy:\n  max_picks: 4\nmechanism: \"jaw\"\n";
constexpr char kHeadOfNow[] = "seed: 7\npolicy:\n  max_attempts: 4\nmechanism: \"jaw\"\n";

std::string NowOr(const Names& names, const std::string& was) {
  const auto name = names.find(was);
  return name == names.end() ? was : name->second;
}

std::vector<std::string> TextsOf(const Database& db, const std::string& query) {
  Statement statement(db, query);
  std::vector<std::string> texts;
  while (statement.Step()) statement.Read(0, texts.emplace_back());
  return texts;
}

// Returns the expression for a column of schema 5 in table `now` of the attached store.
std::string ValueOf5(const std::string& column) {
  if (kMetricsOf5.contains(column)) {
    return fmt::format(
        "(SELECT value FROM store.hypothesis_metrics m WHERE m.trial = now.trial AND m.attempt = "
        "now.attempt AND m.hypothesis = now.hypothesis AND m.metric = '{}')",
        column);
  }
  std::string value = NowOr(kColumnsOf5, column);
  if (!kTextColumnsOf5.contains(column)) return value;
  for (const auto& [was, is] : kValuesOf5) {
    value = fmt::format("CASE WHEN {0} = '{1}' THEN '{2}' ELSE {0} END", value, is, was);
  }
  return value;
}

// A trial with values whose names have changed since, and without the values that schema 5 lacked.
TrialResult TrialOf5(int trial) {
  TrialResult result = FullTrial(trial);
  const TrialResult none;
  result.ended_by = FailureReason::kWrongObject;
  result.errors = none.errors;
  result.layers = none.layers;
  result.instances_tested = none.instances_tested;
  result.instances_graspable = none.instances_graspable;
  for (AttemptRecord& attempt : result.attempts) {
    AttemptRecord other;
    attempt.errors = other.errors;
    attempt.pick_of_image = other.pick_of_image;
    attempt.pose_free = other.pose_free;
    attempt.fill_level = other.fill_level;
    attempt.layer = other.layer;
    attempt.instances_above = other.instances_above;
    attempt.instances_below = other.instances_below;
    attempt.outcome.instances_entangled = other.outcome.instances_entangled;
    attempt.outcome.retention_g = other.outcome.retention_g;
    attempt.outcome.drop_time_s = other.outcome.drop_time_s;
    if (attempt.grasp) {
      attempt.grasp->lift_aside_m.setZero();
      attempt.outcome.failure = FailureReason::kDoublePick;
    }
    attempt.instances[1].missed = FailureReason::kWrongObject;
    attempt.grasps_rejected = {{"palm meets an instance", 12 + trial}, {"tilt", 3}};
    for (HypothesisRecord& hypothesis : attempt.hypotheses) {
      MetricValues metrics;
      for (const MetricValue& value : hypothesis.metrics) {
        if (value.metric != "of_another_version") metrics.Set(value.metric, value.value);
      }
      hypothesis.metrics = metrics;
      hypothesis.raw_score = hypothesis.score;  // nothing was calibrated
    }
  }
  for (InstanceOutcome& outcome : result.outcomes) {
    outcome.deviation = {};
    outcome.size_deviation = 0;
  }
  return result;
}

class Schema5 : public testing::Test {
 protected:
  // Fills the tables of a file of schema 5 with two trials, a crashed trial and settings.
  void SetUp() override {
    const std::filesystem::path now = folder_ / "now";
    {
      ResultsStore store(now, std::string(kHeadOfNow));
      for (int trial = 0; trial < 2; ++trial) store.Write(TrialOf5(trial));
      store.WriteCrashed({2, 0, BinIndex{102}, 7, "ended by signal 11"});
    }
    std::filesystem::copy_file(
        std::filesystem::path(PICKBED_SOURCE_DIR) / "tests/data/previous_version/run" / kStoreFile,
        folder_ / kStoreFile);
    const Database db(folder_ / kStoreFile, Database::Mode::kExisting);
    ASSERT_EQ(db.Setting("schema_version"), "5");
    db.Execute(fmt::format("ATTACH '{}' AS store", (now / kStoreFile).string()));
    for (const std::string& table :
         TextsOf(db, "SELECT name FROM main.sqlite_master WHERE type = 'table'")) {
      if (table == "settings") continue;
      std::string columns, values;
      for (const std::string& column :
           TextsOf(db, fmt::format("SELECT name FROM pragma_table_info('{}', 'main')", table))) {
        const char* comma = columns.empty() ? "" : ", ";
        columns += comma + column;
        values += comma + ValueOf5(column);
      }
      db.Execute(fmt::format("DELETE FROM main.{}", table));
      db.Execute(fmt::format("INSERT INTO main.{} ({}) SELECT {} FROM store.{} now ORDER BY rowid",
                             table, columns, values, NowOr(kTablesOf5, table)));
    }
    db.Execute(
        fmt::format("UPDATE main.settings SET value = '{}' WHERE key = 'scenario'", kHeadOf5));
    db.Execute(fmt::format("UPDATE main.points SET identity = '{0}', settings = '{0}'", kHeadOf5));
  }
  std::string Bytes() const { return ReadFileBytes(folder_ / kStoreFile); }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

// Otherwise the tests below would migrate nothing.
TEST_F(Schema5, RowsHaveTheFormerNames) {
  const Database db(folder_ / kStoreFile, Database::Mode::kExisting);
  EXPECT_THAT(TextsOf(db, "SELECT ended_by FROM trials ORDER BY trial"),
              ElementsAre("wrong_part", "wrong_part", "none"));
  EXPECT_THAT(TextsOf(db, "SELECT DISTINCT physical_loss FROM picks WHERE executed"),
              ElementsAre("took_two"));
  const std::string outcomes = "fates";
  EXPECT_THAT(TextsOf(db, "SELECT loss FROM " + outcomes + " WHERE trial = 1"),
              ElementsAre("none", "disturbed"));
  EXPECT_THAT(TextsOf(db, "SELECT stage FROM timings WHERE trial = 0 ORDER BY stage"),
              ElementsAre("drop", "see"));
  const std::vector<std::string> causes{"palm meets a part", "tilt"};
  EXPECT_EQ(TextsOf(db, "SELECT DISTINCT cause FROM rejections ORDER BY cause"), causes);
  EXPECT_THAT(TextsOf(db, "SELECT quote(mssd_m) FROM hypotheses WHERE mssd_m IS NOT NULL"),
              testing::SizeIs(6));
}

TEST_F(Schema5, IsReadWithAllItsValuesAndNotChanged) {
  const std::string before = Bytes();
  const ResultsStore store = ResultsStore::OpenToRead(folder_, StoreChecks::kRows);
  const std::vector<TrialResult> trials = store.ReadAll();
  ASSERT_EQ(trials.size(), 2u);
  for (int trial = 0; trial < 2; ++trial) ExpectSameTrial(trials[trial], TrialOf5(trial));
  ASSERT_EQ(store.Crashed().size(), 1u);
  const CrashedTrial crashed = store.Crashed()[0];
  EXPECT_EQ(crashed.trial, 2);
  EXPECT_EQ(crashed.bin_index, BinIndex{102});
  EXPECT_EQ(crashed.seed, 7u);
  EXPECT_EQ(crashed.why, "ended by signal 11");
  EXPECT_EQ(store.head().identity, kHeadOfNow);
  ASSERT_EQ(store.head().configurations.size(), 1u);
  EXPECT_EQ(store.head().configurations[0].identity, kHeadOfNow);
  EXPECT_EQ(store.head().configurations[0].seed, 7u);
  EXPECT_EQ(Bytes(), before);
}

TEST_F(Schema5, IsContinued) {
  ResultsStore(folder_, std::string(kHeadOfNow)).Write(FullTrial(3));
  const ResultsStore store = ResultsStore::OpenToRead(folder_, StoreChecks::kRows);
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(0, 1, 2, 3));
  for (int trial = 0; trial < 2; ++trial) {
    ExpectSameTrial(store.Read(trial, trial + 1).at(0), TrialOf5(trial));
  }
  ExpectSameTrial(store.Read(3, 4).at(0), FullTrial(3));
  const Database db(folder_ / kStoreFile, Database::Mode::kExisting);
  for (const auto& [was, is] : kTablesOf5) {
    EXPECT_FALSE(db.HasTable(was)) << was;
    EXPECT_TRUE(db.HasTable(is)) << is;
  }
}

TEST_F(Schema5, ADamagedRowIsNamedWithItsPresentTable) {
  Database(folder_ / kStoreFile, Database::Mode::kExisting)
      .Execute("UPDATE picks SET aimed = -7 WHERE rowid = 2");
  try {
    ResultsStore::OpenToRead(folder_);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("table 'attempts', row 2: the value in column "
                                        "'matched_instance' is not from -1 to"));
  }
}

}  // namespace
}  // namespace pickbed::tests
