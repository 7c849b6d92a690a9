#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <map>

#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/full_trial.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

// Stores of other versions, damaged stores, and folders or disks that refuse a write.

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::Pair;

// The tables of schema 4.
constexpr char kSchema4[] =
    "CREATE TABLE settings (key TEXT PRIMARY KEY, value TEXT);"
    "CREATE TABLE trials (trial INTEGER, parts_dropped INTEGER, parts_cleared INTEGER, "
    "ended_by TEXT, at_rest INTEGER, simulated_s REAL, max_speed_mps REAL, max_spin_radps "
    "REAL, deepest_penetration_m REAL, wake_movement_m REAL, wake_movement_diameters REAL);"
    "CREATE TABLE picks (trial INTEGER, pick INTEGER, loss TEXT, executed INTEGER, "
    "chosen_hypothesis INTEGER, aimed INTEGER, grasp_hypothesis INTEGER, grasp_x_wg TEXT, "
    "grasp_width_m REAL, grasp_score REAL, success INTEGER, physical_loss TEXT, "
    "picked_instance INTEGER, parts_lifted INTEGER, final_opening_m REAL, slip_m REAL, "
    "turn_rad REAL, disturbed INTEGER, is_target INTEGER, parts_touched INTEGER, parts_risen "
    "INTEGER, lift_height_m REAL, contact_force_x_n REAL, contact_force_y_n REAL, "
    "contact_force_z_n REAL, contact_torque_x_nm REAL, contact_torque_y_nm REAL, "
    "contact_torque_z_nm REAL, retreat_contact INTEGER, retreat_opening REAL, set_down "
    "INTEGER, place_error_m REAL, place_turn_rad REAL, contact INTEGER, lifted INTEGER, held "
    "INTEGER, right_part INTEGER, single_part INTEGER, placed INTEGER, vgn_loose INTEGER);"
    "CREATE TABLE hypotheses (trial INTEGER, pick INTEGER, hypothesis INTEGER, object "
    "INTEGER, instance INTEGER, score REAL, mssd_m REAL, mspd_px REAL, add_m REAL, adi_m "
    "REAL, rotation_rad REAL, translation_m REAL, mssd_diameters REAL, correct INTEGER, x_wo "
    "TEXT, x_otrue_obelieved TEXT);"
    "CREATE TABLE instances (trial INTEGER, pick INTEGER, instance INTEGER, object INTEGER, "
    "visible_fraction REAL, recalled INTEGER, missed TEXT);"
    "CREATE TABLE fates (trial INTEGER, instance INTEGER, object INTEGER, picked INTEGER, "
    "asked INTEGER, loss TEXT, pick INTEGER);"
    "CREATE TABLE rejections (trial INTEGER, pick INTEGER, cause TEXT, grasps INTEGER);"
    "CREATE TABLE refusals (trial INTEGER, attempt INTEGER, fault TEXT);"
    "CREATE TABLE timings (trial INTEGER, stage TEXT, seconds REAL);"
    "CREATE UNIQUE INDEX one_row_a_trial ON trials (trial);";

constexpr char kScenario[] = "seed: 42\ntrials: 3\n";
constexpr char kSettings[] = "seed: 42\ntrials: 3\nmechanism: \"jaw\"\n";

// Two trials. The second has an executed pick.
const std::string kRows4 =
    std::string("INSERT INTO settings VALUES ('schema_version', '4'), ('scenario', '") + kSettings +
    "');"
    "INSERT INTO trials VALUES (0, 4, 2, 'none', 1, 2.5, 0.001, 0.002, 0.0003, 0.0004, 0.005);"
    "INSERT INTO trials VALUES (2, 5, 1, 'slipped', 1, 3.5, 0, 0, 0, 0, 0);"
    "INSERT INTO picks (trial, pick, loss, executed, chosen_hypothesis, aimed, grasp_hypothesis, "
    "grasp_x_wg, grasp_width_m, success, slip_m, right_part) VALUES "
    "(2, 0, 'none', 1, 0, 3, 0, '[1,0,0,0.25,0,1,0,0.5,0,0,1,0.75]', 0.0625, 1, 0.5, 1);"
    "UPDATE picks SET picked_instance = 0, parts_lifted = 0, disturbed = 0, is_target = 0, "
    "parts_touched = 0, parts_risen = 0, retreat_contact = 0, set_down = 0, contact = 0, lifted = "
    "0, held = 0, single_part = 0, placed = 0, vgn_loose = 0;"
    "INSERT INTO instances VALUES (2, 0, 3, 0, 0.875, 1, 'none');"
    "INSERT INTO hypotheses VALUES (2, 0, 0, 1, 3, 0.5, 0.001, 2.5, 0.002, 9e999, 0.25, 0.003, "
    "0.0625, 1, '[1,0,0,0.25,0,1,0,0.5,0,0,1,0.75]', '[1,0,0,0,0,1,0,0,0,0,1,0]');"
    "INSERT INTO hypotheses VALUES (2, 0, 1, 1, -1, 0.25, 0.004, 3, 4, 5, 6, 7, 8, 0, "
    "'[1,0,0,0,0,1,0,0,0,0,1,0]', '[1,0,0,0,0,1,0,0,0,0,1,0]');"
    "INSERT INTO timings VALUES (2, 'drop', 1.5);";

void RunSql(const std::filesystem::path& folder, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "results.sqlite").c_str(), &db), SQLITE_OK);
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  sqlite3_close(db);
}

void ExpectTrialsOfSchema4(const ResultsStore& store) {
  std::vector<TrialResult> trials = store.Read(0, 1);
  ASSERT_EQ(trials.size(), 1u);
  trials.push_back(store.Read(2, 3).at(0));
  EXPECT_EQ(trials[0].instances_dropped, 4);
  EXPECT_EQ(trials[0].bin_index, 0);
  EXPECT_EQ(trials[1].trial, 2);
  EXPECT_EQ(trials[1].bin_index, 2) << "random streams are derived from it";
  EXPECT_EQ(trials[1].configuration, 0);
  EXPECT_EQ(trials[1].ended_by, FailureReason::kSlipped);
  EXPECT_EQ(trials[1].seconds.at("drop"), 1.5);
  ASSERT_EQ(trials[1].attempts.size(), 1u);
  const AttemptRecord& pick = trials[1].attempts[0];
  EXPECT_EQ(pick.target, -1);
  EXPECT_EQ(pick.band, -1);
  EXPECT_EQ(pick.matched_instance, 3);
  ASSERT_TRUE(pick.grasp.has_value());
  EXPECT_EQ(pick.grasp->X_WG.translation(), Eigen::Vector3d(0.25, 0.5, 0.75));
  EXPECT_EQ(pick.outcome.slip_m, 0.5);
  ASSERT_EQ(pick.instances.size(), 1u);
  EXPECT_EQ(pick.instances[0].visible_fraction, 0.875);
  ASSERT_EQ(pick.hypotheses.size(), 2u);
  std::map<std::string, double> metrics;
  for (const MetricValue& value : pick.hypotheses[0].metrics) metrics[value.metric] = value.value;
  EXPECT_THAT(
      metrics,
      ElementsAre(Pair("add_m", 0.002), Pair("adi_m", std::numeric_limits<double>::infinity()),
                  Pair("mspd_px", 2.5), Pair("mssd_diameters", 0.0625), Pair("mssd_m", 0.001),
                  Pair("rotation_rad", 0.25), Pair("translation_m", 0.003)));
  EXPECT_EQ(pick.hypotheses[0].X_WO.translation(), Eigen::Vector3d(0.25, 0.5, 0.75));
  EXPECT_EQ(pick.hypotheses[1].translation_m(), 7);
  EXPECT_EQ(pick.hypotheses[0].raw_score, 0.5) << "nothing was calibrated";
  ASSERT_EQ(store.head().configurations.size(), 1u);
  EXPECT_EQ(store.head().configurations[0].seed, 42u);
  EXPECT_EQ(store.head().configurations[0].trials, 3);
  EXPECT_EQ(store.head().configurations[0].identity, kSettings);
}

class ResultsSchemaTest : public testing::Test {
 protected:
  std::string bytes() const { return ReadFileBytes(folder_ / "results.sqlite"); }
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(ResultsSchemaTest, ReadsSchema4WithoutChangingTheFile) {
  RunSql(folder_, kSchema4 + kRows4);
  const std::string before = bytes();
  const ResultsStore store = ResultsStore::OpenToRead(folder_);
  ExpectTrialsOfSchema4(store);
  EXPECT_EQ(store.head().configurations[0].settings, kScenario)
      << "gripper settings do not belong to the scenario";
  EXPECT_EQ(StoredSettings(folder_), kSettings);
  EXPECT_EQ(bytes(), before);
}

TEST_F(ResultsSchemaTest, AddsTrialsToAStoreOfSchema4) {
  RunSql(folder_, kSchema4 + kRows4);
  ResultsStore(folder_, kSettings).Write(FullTrial(1));
  const ResultsStore store = ResultsStore::OpenToRead(folder_);
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(0, 1, 2));
  ExpectSameTrial(store.Read(1, 2).at(0), FullTrial(1));
  ExpectTrialsOfSchema4(store);
}

// A column that was added after schema 5, and the first version that has it.
struct AddedColumn {
  int version;
  const char* table;
  const char* column;
};
constexpr AddedColumn kAddedColumns[] = {
    {7, "trials", "hand_eye_x_m"},
    {7, "trials", "hand_eye_y_m"},
    {7, "trials", "hand_eye_z_m"},
    {7, "trials", "hand_eye_rx_rad"},
    {7, "trials", "hand_eye_ry_rad"},
    {7, "trials", "hand_eye_rz_rad"},
    {7, "trials", "focal_error"},
    {7, "trials", "principal_x_px"},
    {7, "trials", "principal_y_px"},
    {7, "trials", "depth_bias_m"},
    {7, "trials", "depth_scale_error"},
    {7, "trials", "bin_x_m"},
    {7, "trials", "bin_y_m"},
    {7, "trials", "bin_z_m"},
    {7, "trials", "bin_rx_rad"},
    {7, "trials", "bin_ry_rad"},
    {7, "trials", "bin_rz_rad"},
    {7, "attempts", "robot_x_m"},
    {7, "attempts", "robot_y_m"},
    {7, "attempts", "robot_z_m"},
    {7, "attempts", "force_error"},
    {7, "instance_outcomes", "friction_deviation"},
    {7, "instance_outcomes", "mass_deviation"},
    {7, "instance_outcomes", "size_deviation"},
    {8, "attempts", "drop_time_s"},
    {8, "attempts", "fill_level"},
    {8, "attempts", "grasp_tool"},
    {8, "attempts", "instances_above"},
    {8, "attempts", "instances_below"},
    {8, "attempts", "instances_entangled"},
    {8, "attempts", "layer"},
    {8, "attempts", "pick_of_image"},
    {8, "attempts", "retention_g"},
    {9, "attempts", "pose_free"},
    {9, "trials", "instances_graspable"},
    {9, "trials", "instances_tested"},
    {9, "trials", "layers"},
    {10, "hypotheses", "raw_score"},
    {11, "trials", "child_rows"},
    {12, "attempts", "grasp_lift_aside_x_m"},
    {12, "attempts", "grasp_lift_aside_y_m"},
};

// Returns all values of the columns that a version has, in the order of the columns' names.
std::string ValuesOfVersion(const std::filesystem::path& folder, int version) {
  const Database db(folder / kStoreFile, Database::Mode::kExisting);
  std::string values;
  Statement columns(db,
                    "SELECT m.name, c.name FROM sqlite_master m, pragma_table_info(m.name) c WHERE "
                    "m.type = 'table' AND m.name <> 'settings' ORDER BY m.name, c.name");
  while (columns.Step()) {
    std::string table, column;
    columns.Read(0, table);
    columns.Read(1, column);
    const bool is_new = std::any_of(
        std::begin(kAddedColumns), std::end(kAddedColumns), [&](const AddedColumn& added) {
          return added.version > version && added.table == table && added.column == column;
        });
    if (is_new) continue;
    Statement rows(db, fmt::format("SELECT quote({}) FROM {} ORDER BY rowid", column, table));
    while (rows.Step()) {
      std::string value;
      rows.Read(0, value);
      values += fmt::format("{}.{}: {}\n", table, column, value);
    }
  }
  return values;
}

class EarlierSchema : public ResultsSchemaTest, public testing::WithParamInterface<int> {};

TEST_P(EarlierSchema, IsMigratedWithAllItsValuesAndContinued) {
  const int version = GetParam();
  {
    ResultsStore store(folder_, kSettings);
    for (int trial = 0; trial < 2; ++trial) store.Write(FullTrial(trial));
  }
  std::string sql;
  for (const AddedColumn& added : kAddedColumns) {
    if (added.version <= version) continue;
    sql += fmt::format("ALTER TABLE {} DROP COLUMN {};", added.table, added.column);
  }
  RunSql(folder_, sql + fmt::format("UPDATE settings SET value = '{}' WHERE key = "
                                    "'schema_version'",
                                    version));
  const std::string before = ValuesOfVersion(folder_, version), file = bytes();
  EXPECT_THAT(before, HasSubstr("attempts.success: "));
  EXPECT_EQ(ResultsStore::OpenToRead(folder_).ReadAll().size(), 2u);
  EXPECT_EQ(bytes(), file) << "reading changed the file";

  ResultsStore store(folder_, kSettings);
  EXPECT_EQ(ValuesOfVersion(folder_, version), before);
  for (const TrialResult& trial : store.ReadAll()) {
    if (version >= 10) break;  // these have raw scores
    for (const HypothesisRecord& hypothesis : trial.attempts.at(0).hypotheses) {
      EXPECT_EQ(hypothesis.raw_score, hypothesis.score);
    }
  }
  store.Write(FullTrial(2));
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(0, 1, 2));
  ExpectSameTrial(store.Read(2, 3).at(0), FullTrial(2));
}

INSTANTIATE_TEST_SUITE_P(Versions, EarlierSchema, testing::Values(6, 7, 8, 9, 10, 11));

TEST_F(ResultsSchemaTest, RefusesUnknownVersionsInOneLine) {
  ResultsStore(folder_, "s").Write(FullTrial(0));
  for (const auto& [version, wanted] :
       {std::pair("99", "later version of pickbed (schema 99"), std::pair("3", "too old")}) {
    RunSql(folder_, std::string("UPDATE settings SET value = '") + version +
                        "' WHERE key = 'schema_version'");
    for (const auto& open : std::vector<std::function<void()>>{
             [&] { ResultsStore(folder_, "s"); }, [&] { ResultsStore::OpenToRead(folder_); }}) {
      const std::string error = ErrorOf(open);
      EXPECT_THAT(error, HasSubstr(wanted));
      EXPECT_THAT(error, HasSubstr("results.sqlite"));
      EXPECT_THAT(error, Not(HasSubstr("\n")));
    }
  }
}

TEST_F(ResultsSchemaTest, BytesAfterTheLastPageAreRefused) {
  ResultsStore(folder_, "s").Write(FullTrial(0));
  std::ofstream(folder_ / "results.sqlite", std::ios::app) << "x";
  EXPECT_THAT(ErrorOf([&] { ResultsStore::OpenToRead(folder_); }),
              HasSubstr("has 1 bytes after its last page"));
}

TEST_F(ResultsSchemaTest, TruncatedFileIsRefusedWhenOpened) {
  {
    ResultsStore store(folder_, "s");
    for (int trial = 0; trial < 20; ++trial) store.Write(FullTrial(trial));
  }
  const std::string whole = bytes();
  for (const size_t size : {whole.size() / 2, whole.size() - 1, size_t{4096}, size_t{50}}) {
    std::filesystem::resize_file(folder_ / "results.sqlite", size);
    const std::string error = ErrorOf([&] { ResultsStore::OpenToRead(folder_); });
    EXPECT_THAT(error, HasSubstr("results.sqlite")) << size << " bytes";
    EXPECT_THAT(error, HasSubstr("restore the file from a copy"));
    EXPECT_THAT(ErrorOf([&] { ResultsStore(folder_, "s"); }),
                HasSubstr("restore the file from a copy"));
    temporary_.Write("results.sqlite", whole);
  }
}

TEST_F(ResultsSchemaTest, FolderWithoutAStoreIsRefused) {
  EXPECT_THAT(ErrorOf([&] { ResultsStore::OpenToRead(folder_); }), HasSubstr("pickbed run"));
  RunSql(folder_, "CREATE TABLE other (x)");
  EXPECT_THAT(ErrorOf([&] { ResultsStore::OpenToRead(folder_); }),
              HasSubstr("is no results store"));
}

// Returns the error text that `function` throws in a child process, or an empty text. `before` runs
// first in the child and drops its rights or limits its disk space.
std::string ErrorInChild(const std::function<void()>& before,
                         const std::function<void()>& function) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    before();
    std::string error;
    try {
      function();
    } catch (const InputError& caught) {
      error = caught.what();
    } catch (const std::exception& caught) {
      error = std::string("not an InputError: ") + caught.what();
    }
    const ssize_t written = write(ends[1], error.data(), error.size());
    _exit(written == static_cast<ssize_t>(error.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string error(10000, 0);
  const ssize_t got = read(ends[0], error.data(), error.size());
  close(ends[0]);
  waitpid(child, nullptr, 0);
  error.resize(std::max<ssize_t>(got, 0));
  return error;
}

TEST_F(ResultsSchemaTest, ReadOnlyStoreCanBeReadButNotWritten) {
  ResultsStore(folder_, "s").Write(FullTrial(0));
  chmod((folder_ / "results.sqlite").c_str(), 0444);
  chmod(folder_.c_str(), 0555);
  const auto give_up_root = [] {
    constexpr uid_t kNobody = 65534;
    if (geteuid() == 0 && setuid(kNobody) != 0) _exit(2);
  };
  const std::string error =
      ErrorInChild(give_up_root, [&] { ResultsStore(folder_, "s").Write(FullTrial(1)); });
  EXPECT_THAT(error, HasSubstr("results.sqlite"));
  EXPECT_THAT(error, HasSubstr("choose another results folder"));
  EXPECT_THAT(ErrorInChild(give_up_root,
                           [&] {
                             const auto read = ResultsStore::OpenToRead(folder_).ReadAll();
                             if (read.size() != 1) throw InputError("not one trial");
                           }),
              IsEmpty());
  chmod(folder_.c_str(), 0755);
}

TEST_F(ResultsSchemaTest, FullDiskKeepsFinishedTrials) {
  constexpr rlim_t kDiskBytes = 200000;
  const auto fill_disk = [] {
    signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit then fails and does not kill
    const rlimit limit{kDiskBytes, kDiskBytes};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(2);
  };
  const std::string error = ErrorInChild(fill_disk, [&] {
    ResultsStore store(folder_, "s");
    for (int trial = 0; trial < 1000; ++trial) store.Write(FullTrial(trial));
  });
  EXPECT_THAT(error, HasSubstr("results.sqlite"));
  EXPECT_THAT(error, HasSubstr("resume the run or sweep"));
  ResultsStore store(folder_, "s");
  const std::vector<int> kept = store.FinishedTrials();
  ASSERT_GT(kept.size(), 3u);
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], static_cast<int>(i));
  ExpectSameTrial(store.ReadAll().back(), FullTrial(kept.back()));
  store.Write(FullTrial(static_cast<int>(kept.size())));
}

}  // namespace
}  // namespace pickbed::tests
