#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "eval/benchmark/crops.h"
#include "eval/replay/replay.h"
#include "eval/store/former_names.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "eval/sweep/sweep_spec.h"
#include "eval/tolerance/samples.h"
#include "grasp/plan/plan.h"
#include "perception/training/training.h"
#include "perception/training/verifier_training.h"
#include "scenes/base/settings_names.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/support/temporary_folder.h"

// Files that the version before schema 6 wrote (tests/data/previous_version): a run, an occlusion
// run, a sweep, and their settings files. The names of now are applied to them, and no value
// changes.

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::Eq;
using testing::IsEmpty;
using testing::SizeIs;

// Columns, JSON keys and values: before -> now.
const std::map<std::string, std::string> kColumns{
    {"point", "configuration"},
    {"scene", "bin_index"},
    {"pick", "attempt"},
    {"loss", "failure"},
    {"became", "outcome"},
    {"parts_in_view", "instances_in_view"},
    {"parts_dropped", "instances_dropped"},
    {"parts_cleared", "instances_cleared"},
    {"parts_touched", "instances_touched"},
    {"parts_lifted", "instances_lifted"},
    {"turn_deg", "in_hand_rotation_error_deg"},
    {"disturbed", "neighbors_displaced"},
    {"place_turn_deg", "place_rotation_error_deg"},
    {"right_part", "right_instance"},
    {"single_part", "single_instance"},
    {"attempts", "executed_grasps"},
    {"visible_least", "visible_min"},
    {"visible_most", "visible_max"},
    {"looks", "attempts"},
    {"least", "visible_min"},
    {"most", "visible_max"},
    {"losses", "failures"},
    {"points", "configurations"},
};
const std::map<std::string, std::string> kValues{
    {"lost", "failed"},
    {"estimator.mode=hard", "estimator.mode=accurate"},
    // curve.csv had quotes also around names that need none.
    {"\"\"", ""},
    {"\"estimator.mode=hard\"", "estimator.mode=accurate"}};

std::string Mapped(const std::string& word, const std::map<std::string, std::string>& names) {
  const auto name = names.find(word);
  return name == names.end() ? word : name->second;
}

std::string MappedCsv(const std::string& csv) {
  std::string text;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    const bool header = text.empty();
    std::string mapped;
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');) {
      mapped += ',';
      mapped += Mapped(cell, header ? kColumns : kValues);
    }
    text += mapped.substr(1) + "\n";
  }
  return text;
}

nlohmann::json MappedJson(const nlohmann::json& json) {
  if (json.is_array()) {
    nlohmann::json mapped = nlohmann::json::array();
    for (const auto& item : json) mapped.push_back(MappedJson(item));
    return mapped;
  }
  if (json.is_string()) return Mapped(json.get<std::string>(), kValues);
  if (!json.is_object()) return json;
  nlohmann::json mapped = nlohmann::json::object();
  for (const auto& [key, value] : json.items()) mapped[Mapped(key, kColumns)] = MappedJson(value);
  return mapped;
}

// A table with the columns of `like`, without the cells that had another rule in the earlier
// version: intervals of few bins.
std::string ComparableCsv(const std::string& csv, const std::string& like) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line + ",");
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  };
  const std::vector<std::string> wanted = split(like.substr(0, like.find('\n')));
  std::istringstream lines(csv);
  std::string line, text;
  std::getline(lines, line);
  const std::vector<std::string> names = split(line);
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = split(line);
    for (const std::string& name : wanted) {
      if (name.ends_with("_low") || name.ends_with("_high")) continue;
      const auto at = std::find(names.begin(), names.end(), name);
      text += at == names.end() ? name + " is missing," : cells.at(at - names.begin()) + ",";
    }
    text += "\n";
  }
  return text;
}

// Expects every value of the earlier version in `now`, except intervals and picks_per_hour, which
// have another rule.
void ExpectKept(const nlohmann::json& now, const nlohmann::json& before, const std::string& where) {
  if (before.is_array()) {
    ASSERT_EQ(now.size(), before.size()) << where;
    for (size_t i = 0; i < before.size(); ++i) ExpectKept(now[i], before[i], where);
    return;
  }
  if (!before.is_object()) {
    EXPECT_EQ(now, before) << where;
    return;
  }
  for (const auto& [key, value] : before.items()) {
    if (key.ends_with("ci95") || key == "picks_per_hour") continue;
    ASSERT_TRUE(now.contains(key)) << where << "." << key;
    ExpectKept(now[key], value, where + "." + key);
  }
}

class PreviousVersion : public testing::Test {
 protected:
  PreviousVersion() {
    fs::copy(fs::path(PICKBED_SOURCE_DIR) / "tests/data/previous_version", folder_,
             fs::copy_options::recursive);
    before_ = SetDeprecationListener([this](const std::string& line) { lines_.insert(line); });
  }
  ~PreviousVersion() override { SetDeprecationListener(before_); }

  std::string Read(const std::string& file) const { return ReadFileBytes(folder_ / file); }
  LoadedScenario Scenario(const std::string& file) const {
    return FindScenario({(folder_ / file).string(), {}, "objects", {}});
  }
  Sweep LoadSweep() const {
    return MakeSweep(LoadSweepSpec(folder_ / "sweep.yaml"), folder_ / "sweep", "objects");
  }
  void RunSql(const std::string& file, const std::string& sql) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((folder_ / file).c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
    sqlite3_close(db);
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "previous";
  std::set<std::string> lines_;  // deprecations

 private:
  DeprecationListener before_;
};

TEST_F(PreviousVersion, ResultFilesKeepTheirValues) {
  const std::pair<const char*, const char*> kFiles[] = {{"trials.csv", kTrialsFile},
                                                        {"picks.csv", kAttemptsFile},
                                                        {"parts.csv", kInstanceOutcomesFile},
                                                        {"points.csv", kConfigurationsFile},
                                                        {"curve.csv", kCurveFile}};
  for (const std::string run : {"run/", "occlusion/", "sweep/"}) {
    std::map<std::string, std::string> before;
    for (const auto& [was, is] : kFiles) {
      if (fs::exists(folder_ / (run + was))) before[is] = MappedCsv(Read(run + was));
    }
    ASSERT_GE(before.size(), 4u);
    const auto summary = MappedJson(nlohmann::json::parse(Read(run + kSummaryFile)));
    WriteSweepFiles(folder_ / run);
    for (const auto& [file, text] : before) {
      EXPECT_EQ(ComparableCsv(Read(run + file), text), ComparableCsv(text, text)) << run << file;
    }
    ExpectKept(nlohmann::json::parse(Read(run + kSummaryFile)), summary, run);
    for (const char* former : {"picks.csv", "parts.csv", "points.csv"}) {
      EXPECT_FALSE(fs::exists(folder_ / (run + former))) << former;
    }
  }
  EXPECT_THAT(lines_, IsEmpty()) << "the settings of a store are read without a report";
}

TEST_F(PreviousVersion, ReadingDoesNotChangeTheStore) {
  const std::string bytes = Read("run/results.sqlite");
  EXPECT_THAT(ResultsStore::OpenToRead(folder_ / "run").ReadAll(), SizeIs(2));
  EXPECT_EQ(Read("run/results.sqlite"), bytes);
}

TEST_F(PreviousVersion, IdentitiesAreThoseOfNow) {
  for (const std::string run : {"run", "occlusion"}) {
    const LoadedScenario scenario = Scenario(run + "/scenario.yaml");
    EXPECT_EQ(ResultsStore::OpenToRead(folder_ / run).head().identity,
              RunIdentity(scenario.spec, scenario.objects))
        << run;
  }
  const StoreHead stored = ResultsStore::OpenToRead(folder_ / "sweep").head();
  const StoreHead head = HeadOf(LoadSweep(), folder_ / "sweep");
  EXPECT_EQ(stored.identity, head.identity);
  ASSERT_EQ(stored.configurations.size(), 2u);
  EXPECT_EQ(stored.configurations[1].name, "estimator.mode=accurate");
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(stored.configurations[i].identity, head.configurations[i].identity);
    EXPECT_EQ(stored.configurations[i].settings, head.configurations[i].settings);
  }
}

TEST_F(PreviousVersion, AChangedSettingIsStillAnotherIdentity) {
  LoadedScenario scenario = Scenario("run/scenario.yaml");
  scenario.spec.policy.max_attempts += 1;
  EXPECT_NE(ResultsStore::OpenToRead(folder_ / "run").head().identity,
            RunIdentity(scenario.spec, scenario.objects));
}

TEST_F(PreviousVersion, StoreIsContinued) {
  const Sweep sweep = LoadSweep();
  TrialResult added;
  added.trial = 7;
  {
    ResultsStore store(folder_ / "sweep", HeadOf(sweep, folder_ / "sweep"));
    store.Write(added);
  }
  EXPECT_THAT(ResultsStore::OpenToRead(folder_ / "sweep").FinishedTrials(), ElementsAre(0, 1, 7));
  RequireNoOtherSweep(folder_ / "sweep",
                      SweepText(LoadSweepSpec(folder_ / "sweep.yaml"), folder_ / "sweep"));
}

TEST_F(PreviousVersion, EachSettingsFileIsReportedInOneLine) {
  Scenario("scenario.yaml");
  ASSERT_THAT(lines_, SizeIs(1));
  const std::string line = *lines_.begin();
  for (const char* name :
       {"'foreign'", "'mode: hard'", "'stop: look_again'", "'max_picks'", "'success: right_part'",
        "'least'", "'most'", "'tries'", "'level_tries'", "'least_hidden'"}) {
    EXPECT_THAT(line, testing::HasSubstr(name));
  }
  EXPECT_EQ(line.find('\n'), std::string::npos);
  LoadSweepSpec(folder_ / "sweep.yaml");
  LoadSweep();  // reads scenario.yaml once per configuration
  EXPECT_THAT(lines_, SizeIs(2));
}

TEST_F(PreviousVersion, SettingsFilesOfNowHaveNoFormerName) {
  const LoadedScenario scenario = Scenario("scenario.yaml");
  lines_.clear();
  ScenarioSpec spec = scenario.spec;
  spec.places.clear();
  const auto visit = [&](SettingsVisitor& v) { spec.Visit(v); };
  const std::string now = WriteSettings(visit);
  EXPECT_EQ(scenes::WithCurrentNames(now, visit).text, now);
}

TEST_F(PreviousVersion, RenamedValuesAreRead) {
  RunSql("run/results.sqlite",
         "UPDATE picks SET loss = 'took_two', physical_loss = 'took_two' WHERE trial = 0 AND pick "
         "= 1; UPDATE picks SET loss = 'wrong_part' WHERE trial = 1 AND pick = 1;"
         "UPDATE fates SET loss = 'disturbed' WHERE trial = 0 AND instance = 3;"
         "UPDATE trials SET ended_by = 'wrong_part' WHERE trial = 0;"
         "UPDATE instances SET missed = 'wrong_part' WHERE trial = 0 AND pick = 0 AND instance = 1;"
         "UPDATE rejections SET cause = 'palm meets a part' WHERE trial = 1 AND cause = 'tilt';"
         "INSERT INTO timings VALUES (0, 'estimate/look_alikes', 0.25), (0, 'estimate/suppress', "
         "0.5);");
  const std::vector<TrialResult> trials = ResultsStore::OpenToRead(folder_ / "run").ReadAll();
  ASSERT_EQ(trials.size(), 2u);
  EXPECT_EQ(trials[0].attempts.at(1).failure, FailureReason::kDoublePick);
  EXPECT_EQ(trials[0].attempts.at(1).outcome.failure, FailureReason::kDoublePick);
  EXPECT_EQ(trials[1].attempts.at(1).failure, FailureReason::kWrongObject);
  EXPECT_EQ(trials[0].ended_by, FailureReason::kWrongObject);
  EXPECT_THAT(trials[0].outcomes,
              testing::Contains(
                  testing::Field(&InstanceOutcome::failure, FailureReason::kNeighborDisplaced)));
  EXPECT_THAT(
      trials[0].attempts.at(0).instances,
      testing::Contains(testing::Field(&InstanceRecord::missed, FailureReason::kWrongObject)));
  const auto rejected = [&](const std::string& cause) {
    return std::ranges::any_of(trials, [&](const TrialResult& trial) {
      return std::ranges::any_of(trial.attempts, [&](const AttemptRecord& attempt) {
        return attempt.grasps_rejected.contains(cause);
      });
    });
  };
  for (const RenamedCause& cause : kRenamedCauses) {
    EXPECT_TRUE(rejected(std::string(cause.is))) << cause.is;
    EXPECT_FALSE(rejected(std::string(cause.was))) << cause.was;
  }
  EXPECT_THAT(trials[0].seconds, testing::Contains(testing::Key("capture")));
  EXPECT_THAT(trials[0].seconds, testing::Not(testing::Contains(testing::Key("see"))));
  EXPECT_THAT(trials[0].seconds,
              testing::Contains(testing::Pair("estimate/ambiguous_poses", 0.25)));
  EXPECT_THAT(trials[0].seconds,
              testing::Contains(testing::Pair("estimate/non_maximum_suppression", 0.5)));
}

// The planner has changed since: it checks candidates in another order and stores the tool. So the
// grasps and what follows them differ.
TEST_F(PreviousVersion, ReplayGivesTheRecordedScenesImagesAndHypotheses) {
  const RecordedTrial recorded = ReadRecordedTrial({folder_ / "sweep", 1}, "objects");
  EXPECT_THAT(recorded.changes, IsEmpty());
  const ReplayReport report = ReplayTrial(recorded, nullptr, {});
  ASSERT_FALSE(report.stages.empty());
  int compared = 0;
  for (const StageReplay& stage : report.stages) {
    if (stage.attempt > 0 || stage.stage >= TrialStage::kGrasp) continue;
    EXPECT_EQ(stage.verdict, ReplayVerdict::kSame);
    ++compared;
  }
  EXPECT_EQ(compared, 3);
  EXPECT_THAT(lines_, IsEmpty());
}

TEST_F(PreviousVersion, PicturesAreFoundByTheirFormerNames) {
  const fs::path folder = PicturesOf(folder_ / "run", 1);
  const std::vector<fs::path> pictures{fs::directory_iterator(folder), fs::directory_iterator()};
  ASSERT_THAT(pictures, SizeIs(1));
  const std::string name = pictures[0].filename().string();
  int attempt = -1;
  ASSERT_EQ(std::sscanf(name.c_str(), "pick_%d_lost.jpg", &attempt), 1) << name;
  EXPECT_EQ(FindPicture(folder, FailurePicture(attempt)), pictures[0]);
  EXPECT_EQ(FindPicture(folder, FailurePicture(attempt + 1)), fs::path());
}

TEST(FormerNames, MergedStoresKeepTheOrderOfTheirIdentities) {
  StoredConfiguration first;
  first.identity = "seed: 1\nestimator:\n  mode: \"hard\"\nmechanism: \"jaw\"\nstroke_m: 0.08\n";
  first.name = "a/b:estimator.mode=hard,method=hard";
  first.trials = 3;
  const std::string run =
      "seed: 2\npolicy:\n  max_picks: 4\nmechanism: \"jaw\"\n# part rod is 0123\n";
  StoreHead head{"", {first}};
  const std::string line = SweepIdentity({first});
  const auto former = [](const std::string& text) {
    return "point" + text.substr(std::string("configuration").size());
  };
  head.identity = run + former(line) + run;
  const StoreHead current = WithCurrentNames(head);
  const std::string now =
      "seed: 2\npolicy:\n  max_attempts: 4\nmechanism: \"jaw\"\n# part rod is 0123\n";
  StoredConfiguration updated = first;
  updated.identity =
      "seed: 1\nestimator:\n  mode: \"accurate\"\nmechanism: \"jaw\"\nstroke_m: 0.08\n";
  updated.name = "a/b:estimator.mode=accurate,method=hard";
  EXPECT_EQ(current.identity, now + SweepIdentity({updated}) + now);
  EXPECT_EQ(current.configurations.at(0).identity, updated.identity);
  EXPECT_EQ(current.configurations.at(0).name, updated.name);
  EXPECT_EQ(WithCurrentNames(current).identity, current.identity) << "not idempotent";
}

// Writes settings with their first names and reads them again.
template <typename Options>
void ExpectFirstNamesAreRead(Options options) {
  const auto visit = [&](SettingsVisitor& v) { options.Visit(v); };
  const std::string first = WriteSettingsKey(visit), now = WriteSettings(visit);
  EXPECT_NE(first, now) << "nothing was renamed";
  EXPECT_EQ(scenes::WithCurrentNames(first, visit).text, now);
  Options again;
  ReadSettingsText(first, "former", [&](SettingsVisitor& v) { again.Visit(v); });
  EXPECT_EQ(WriteSettings([&](SettingsVisitor& v) { again.Visit(v); }), now);
}

TEST(FormerNames, AllSettingsAreReadByTheirFirstNames) {
  ScenarioSpec scenario;
  scenario.objects.resize(2);
  scenario.objects[1].distractor = true;
  scenario.estimator.mode = "accurate";
  scenario.policy.stop = "capture_again";
  ExpectFirstNamesAreRead(scenario);
  ExpectFirstNamesAreRead(ToleranceOptions());
  ExpectFirstNamesAreRead(TrainingOptions());
  ExpectFirstNamesAreRead(VerifierTrainingOptions());
  ExpectFirstNamesAreRead(PlanOptions());
  ExpectFirstNamesAreRead(CropBenchmarkOptions());
}

// Page for users with all former names.
class OldToNewPage : public testing::Test {
 protected:
  static std::string Source(const fs::path& file) {
    return ReadFileBytes(fs::path(PICKBED_SOURCE_DIR) / file);
  }
  // Expects a table row that begins with these cells. An empty cell matches any text.
  void ExpectRow(const std::vector<std::string>& cells, const std::string& origin) const {
    std::string row = "\n\\|";
    for (const std::string& cell : cells)
      row += cell.empty() ? "[^|\n]*\\|" : " `" + cell + "` \\|";
    EXPECT_TRUE(std::regex_search(page_, std::regex(row)))
        << "docs/pages/reference/old_to_new.md has no row for " << testing::PrintToString(cells)
        << " of " << origin;
  }

  const std::string page_ = Source("docs/pages/reference/old_to_new.md");
};

// Scans the sources, because only they contain the former names of all settings structs.
TEST_F(OldToNewPage, ListsEveryRenamedSetting) {
  const std::regex key("RenamedKey\\(\\s*\"(\\w+)\",\\s*\"(\\w+)\"\\)");
  const std::regex value("RenamedValue\\(\\s*\"\\w+\",\\s*\"(\\w+)\",\\s*\"(\\w+)\"\\)");
  int found = 0;
  for (const char* layer : {"scenes", "perception", "grasp", "eval"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(PICKBED_SOURCE_DIR) / layer)) {
      if (entry.path().extension() != ".cpp") continue;
      const std::string source = ReadFileBytes(entry.path());
      const std::sregex_iterator end;
      for (std::sregex_iterator match(source.begin(), source.end(), key); match != end; ++match) {
        ExpectRow({(*match)[1], (*match)[2]}, entry.path());
        ++found;
      }
      for (std::sregex_iterator match(source.begin(), source.end(), value); match != end; ++match) {
        ExpectRow({"", (*match)[1], (*match)[2]}, entry.path());
        ++found;
      }
    }
  }
  EXPECT_GT(found, 40) << "the sources declare former names in another way";
}

TEST_F(OldToNewPage, ListsEveryRenamedColumnAndValueOfTheResults) {
  for (const auto& [was, is] : kColumns) ExpectRow({was, is}, "the result files");
  ExpectRow({"lost", "failed"}, "the result files");
  const std::string schema = Source("eval/store/schema.cpp");
  const std::regex column("\\{\"\\w+\", \"(\\w+)\", \"(\\w+)\"\\}");
  int found = 0;
  const std::sregex_iterator end;
  for (std::sregex_iterator match(schema.begin(), schema.end(), column); match != end; ++match) {
    ExpectRow({(*match)[1], (*match)[2]}, "eval/store/schema.cpp");
    ++found;
  }
  EXPECT_GT(found, 20) << "the schema declares former names in another way";
  for (const FailureRow& row : FailureTable()) {
    if (row.former_name.empty()) continue;
    ExpectRow({std::string(row.former_name), std::string(row.name)}, "the failure reasons");
  }
  for (const RenamedCause& cause : kRenamedCauses) {
    ExpectRow({std::string(cause.was), std::string(cause.is)}, "the causes of rejected grasps");
  }
}

}  // namespace
}  // namespace pickbed::tests
