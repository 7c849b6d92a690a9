// Every column and key that a writer writes must be in the reference.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/benchmark/bins.h"
#include "eval/benchmark/crops_report.h"
#include "eval/bop/layout.h"
#include "eval/bop/results_csv.h"
#include "eval/budget/report.h"
#include "eval/compare/paired_tables.h"
#include "eval/estimate/report.h"
#include "eval/execution/execution.h"
#include "eval/execution/report.h"
#include "eval/export/grasps_csv.h"
#include "eval/export/made_object_json.h"
#include "eval/export/scene_json.h"
#include "eval/export/visibility_csv.h"
#include "eval/metrics/metric_table.h"
#include "eval/metrics/result_columns.h"
#include "eval/reference/pages.h"
#include "eval/replay/replay.h"
#include "eval/store/sqlite.h"
#include "eval/store/store_columns.h"
#include "eval/summary/occlusion_curve.h"
#include "eval/summary/result_files.h"
#include "eval/summary/run_columns.h"
#include "eval/tolerance/pick_forecast.h"
#include "eval/tolerance/report.h"
#include "eval/tolerance/samples.h"
#include "eval/train/page.h"
#include "scenes/base/files.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/eval/full_trial.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/stub_trials.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using nlohmann::json;
using testing::IsEmpty;
using testing::Not;

// Returns the described columns of a file. One entry of the reference can describe several files.
ResultColumns ColumnsOf(const std::string& file) {
  for (const ResultPage& page : AllResultFiles()) {
    for (const ResultFolder& folder : page.folders) {
      for (const ResultFile& known : folder.files) {
        if (known.columns.empty()) continue;  // described on another page
        std::istringstream names(known.name);
        for (std::string name; std::getline(names, name, ',');) {
          if (name == file || name == " " + file) return known.columns;
        }
      }
    }
  }
  ADD_FAILURE() << file << " is not in the reference";
  return {};
}

std::vector<std::string> NamesOf(const ResultColumns& columns) {
  std::vector<std::string> names;
  for (const ResultColumn& column : columns) names.push_back(column.name);
  return names;
}

std::vector<std::string> HeaderOf(const std::string& csv) {
  std::istringstream line(csv.substr(0, csv.find('\n')));
  std::vector<std::string> names;
  for (std::string name; std::getline(line, name, ',');) names.push_back(name);
  return names;
}

void ExpectHeader(const std::string& csv, const std::string& file) {
  EXPECT_EQ(HeaderOf(csv), NamesOf(ColumnsOf(file))) << file;
}

void ExpectHeader(const std::string& csv, const ResultColumns& columns) {
  EXPECT_EQ(HeaderOf(csv), NamesOf(columns));
}

std::vector<std::string> Segments(const std::string& path) {
  std::istringstream text(path);
  std::vector<std::string> segments;
  for (std::string segment; std::getline(text, segment, '.');) segments.push_back(segment);
  return segments;
}

// Whether a path of a JSON file has the form of a key. A word in capitals matches any name.
bool Matches(const std::vector<std::string>& path, const std::string& key) {
  const std::vector<std::string> pattern = Segments(key);
  return std::equal(path.begin(), path.end(), pattern.begin(), pattern.end(),
                    [](const std::string& name, const std::string& form) {
                      const bool is_list = name.ends_with("[]");
                      const std::string stem = form.substr(0, form.size() - (is_list ? 2 : 0));
                      const bool is_any = !stem.empty() && std::all_of(stem.begin(), stem.end(),
                                                                       [](unsigned char c) {
                                                                         return std::isupper(c);
                                                                       });
                      return name == form || (is_any && is_list == form.ends_with("[]"));
                    });
}

void ExpectPaths(const json& value, std::vector<std::string> path, const ResultColumns& keys) {
  if (value.is_object()) {
    for (const auto& [name, item] : value.items()) {
      path.push_back(name);
      ExpectPaths(item, path, keys);
      path.pop_back();
    }
    return;
  }
  if (value.is_array() && value.empty()) return;  // a list of unknown items
  if (value.is_array() && value.front().is_object()) {
    if (path.empty()) path.emplace_back();
    path.back() += "[]";
    for (const json& item : value) ExpectPaths(item, path, keys);
    return;
  }
  const bool known = std::any_of(keys.begin(), keys.end(),
                                 [&](const ResultColumn& key) { return Matches(path, key.name); });
  EXPECT_TRUE(known) << "no description of " << testing::PrintToString(path);
}

void ExpectKeys(const std::string& text, const std::string& file) {
  SCOPED_TRACE(file);
  const json value = json::parse(text);
  ASSERT_FALSE(value.empty());
  ExpectPaths(value, {}, ColumnsOf(file));
}

PickForecast Forecast() {
  PickForecast forecast;
  forecast.object = "cube";
  Predictor known{"mssd", "MSSD", {}, {}}, unknown{"add", "ADD", {}, {}};
  known.auc.successes = known.auc.failures = 2;
  forecast.predictors = {known, unknown};
  return forecast;
}

TEST(FilePages, HaveHelpAndNoRepeatedNameInEveryTable) {
  for (const ResultPage& page : AllResultFiles()) {
    for (const ResultFolder& folder : page.folders) {
      for (const ResultFile& file : folder.files) {
        EXPECT_THAT(file.help, Not(IsEmpty())) << file.name;
        std::vector<std::string> names = NamesOf(file.columns);
        for (const ResultColumn& column : file.columns) {
          EXPECT_THAT(column.help, Not(IsEmpty())) << file.name << " " << column.name;
        }
        std::sort(names.begin(), names.end());
        EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end()) << file.name;
      }
    }
  }
}

TEST(FilePages, HaveEveryColumnOfARun) {
  const TemporaryFolder folder;
  SweepOptions options;
  options.out = folder.path() / "sweep";
  options.picture_trials = options.failure_picture_trials = 0;
  options.make = StubTrials();
  RunSweep(StubSweep(2, 2), options, {});
  int tables = 0;
  for (const auto& entry : std::filesystem::directory_iterator(options.out)) {
    if (entry.path().extension() != ".csv") continue;
    ++tables;
    ExpectHeader(ReadFileBytes(entry.path()), entry.path().filename().string());
  }
  EXPECT_EQ(tables, 6);

  const Database store(options.out / "results.sqlite", Database::Mode::kExisting);
  Statement columns(store,
                    "SELECT m.name, p.name FROM sqlite_master m, pragma_table_info(m.name) p "
                    "WHERE m.type = 'table'");
  int count = 0;
  while (columns.Step()) {
    std::string table, column;
    columns.Read(0, table);
    columns.Read(1, column);
    ++count;
    EXPECT_THAT(NamesOf(ColumnsOf(table)), testing::Contains(column)) << table;
  }
  EXPECT_GT(count, 100);
}

TEST(FilePages, HaveEveryColumnOfOtherTablesOfARun) {
  ExpectHeader(CurveCsv({}), "curve.csv");
  ExpectHeader(HiddenShareCsv({}), "hidden_share.csv");
  ExpectHeader(PickChancesCsv({}, {}, {}), "pick_chances.csv");
}

TEST(FilePages, HaveEveryKeyOfASummary) {
  RunSummary summary = Summarize({FullTrial(0), FullTrial(1)});
  summary.refused = {{0, {1, {"not at rest"}}}};
  summary.crashed = {{3, 0, BinIndex(3), 5, "killed"}};
  summary.stop = StopState();
  summary.forecasts = {Forecast()};
  BandStatistics band;
  band.attempts = 2;
  band.errors.attempts = 1;
  band.failures = {{"slipped", 1}};
  summary.bands = {band, BandStatistics()};
  ExpectKeys(SummaryJson(summary), "summary.json");
}

TEST(FilePages, HaveEveryColumnAndKeyOfBudgetAndComparison) {
  BudgetRuns runs;
  runs.as_run = StubTrials(6);
  runs.reruns = {{OracleTable()[0], StubTrials(6)}};
  runs.forecasts = {Forecast()};
  ExpectHeader(BudgetCsv(runs), "budget.csv");
  ExpectKeys(BudgetJson(runs), "budget.json");
  const PairedComparison paired = ComparePaired(StubTrials(12), StubTrials(12, {12, 5, 0.2}));
  ASSERT_FALSE(paired.statistics.empty());
  PairedComparison with_odds = paired;
  with_odds.statistics[0].odds_ratio = OddsRatio();
  ExpectKeys(ComparisonJson(std::vector<ConfigurationComparison>{{"a", "b", with_odds}}),
             "JSON file");
}

TEST(FilePages, HaveEveryColumnOfMeasurements) {
  ExpectHeader(ComparisonCsv({}, {}), "comparison.csv");
  ExpectHeader(HypothesesCsv({}, {}), "hypotheses.csv");
  ExpectHeader(InstancesCsv(std::vector<ComparedRow>(), {}), EstimatedInstancesColumns());
  ExpectHeader(WriteEstimates({}), "ESTIMATOR_DATASET-SPLIT.csv");
  ExpectHeader(AxesCsv({}), "axes.csv");
  ExpectHeader(PairsCsv({}), "pairs.csv");
  ExpectHeader(PredictorsCsv({}), "predictors.csv");
  ExpectHeader(PredictorsCsv({}), "run_predictors.csv");
  ExpectHeader(BinTableCsv({BinScenario()}), "bins.csv");
  ExpectHeader(CropTableCsv({}, {}), "crops.csv");
  ExpectHeader(CropViewsCsv({}, {}), "views.csv");
  ExpectHeader(CropDifferencesCsv({}), "differences.csv");
  ExpectHeader(CropTimingsCsv({}), CropTimingsColumns());
  EXPECT_EQ(NamesOf(ColumnsOf("samples.csv")), NamesOf(SamplesColumns()));
}

TEST(FilePages, HaveEveryColumnAndKeyOfScenesAndObjects) {
  CertifiedScene made;
  made.scene.objects = {{InstanceId{0}, ObjectId{0}, Pose::Identity()}};
  made.certificate.energy = {{0.1, 0.2, 0.3}};
  made.refused = {{0, {"not at rest"}}};
  ExpectKeys(SceneJson(made.scene, EasyCube()), "scene.json");
  ExpectKeys(CertificateJson(made), "certificate.json");
  MadeObject object;
  object.inspected.fixed = object.inspected.notes = {"a note"};
  object.seconds = {{"pieces", 1.5}};
  ExpectKeys(MadeObjectJson("key", object), "made.json");
  ExpectHeader(GraspsCsv({}), "grasps.csv");
  ExpectHeader(VisibilityCsv({}, Observation(), {}), "visible.csv");
  ExpectHeader(ReplayCsv({}), "stages.csv");
  EXPECT_EQ(NamesOf(CurvesColumns({"rod"})).back(), "rod");
}

TEST(FilePages, HaveEveryKeyOfADataset) {
  const TemporaryFolder folder;
  MakeSmall(folder.path(), 1, 1);
  int files = 0;
  for (const DatasetFile& file : DatasetFiles()) {
    std::string name = file.name;
    const auto replace = [&](const std::string& word, const std::string& by) {
      if (const size_t at = name.find(word); at != std::string::npos) {
        name.replace(at, word.size(), by);
      }
    };
    replace("SPLIT", "test");
    replace("SCENE", SceneFolderName(1));
    const std::filesystem::path path = folder.path() / name;
    ASSERT_TRUE(std::filesystem::exists(path)) << path;
    ++files;
    ExpectKeys(ReadFileBytes(path), file.name);
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
    const bool is_copy = entry.path().parent_path().filename() == "models_eval";
    if (entry.path().extension() == ".json" && !is_copy) --files;
  }
  EXPECT_EQ(files, 0) << "a JSON file is not in the reference";
}

TEST(FilePages, HaveEveryKeyOfAnExecution) {
  std::vector<ExecutedPick> picks;
  for (int i = 0; i < 12; ++i) {
    ExecutedPick& pick = picks.emplace_back();
    pick.method = i % 2 == 0 ? "a" : "b";
    pick.scene_id = i / 2;
    pick.object_id = 1;
    pick.score = pick.errors.mssd_m = i;
    pick.success = i < 4;
    if (!pick.success) pick.failure = FailureReason::kSlipped;
  }
  ExpectKeys(ExecutionJson(StatisticsOf({"a", "b"}, picks)), kExecutionSummaryFile);
  ExpectHeader(HeaderLine(PicksColumns()), kPicksFile);
}

TEST(FilePages, AnAddedMetricIsInTheTables) {
  const ScopedMetric metric({"offset", "mm", "offset", "a metric of a test",
                             [](const MetricInput&) { return 0.0; }, kRecorded});
  EXPECT_THAT(NamesOf(AttemptsColumns()), testing::Contains("offset_mm"));
  EXPECT_THAT(NamesOf(HypothesesColumns()), testing::Contains("offset_mm"));
}

TEST(FilePages, AKeyWithoutDescriptionIsFound) {
  const std::vector<std::string> path{"failures", "slipped"};
  EXPECT_TRUE(Matches(path, "failures.REASON"));
  EXPECT_FALSE(Matches(path, "failures.REASON.count"));
  EXPECT_FALSE(Matches(path, "failure.REASON"));
  EXPECT_TRUE(Matches({"rows[]", "name"}, "rows[].name"));
  EXPECT_FALSE(Matches({"rows", "name"}, "rows[].name"));
  EXPECT_TRUE(Matches({"7[]", "obj_id"}, "ID[].obj_id"));
  EXPECT_FALSE(Matches({"7", "obj_id"}, "ID[].obj_id"));
}

TEST(ResultColumns, UnitsAreInTheNameUnlessGiven) {
  EXPECT_EQ(UnitInName("slip_mm"), "mm");
  EXPECT_EQ(UnitInName("max_speed_mps"), "m/s");
  EXPECT_EQ(UnitInName("torque_x_nm"), "N m");
  EXPECT_EQ(UnitInName("median_mssd_diameters"), "diameters");
  EXPECT_EQ(UnitInName("instances"), "");
  EXPECT_EQ(UnitOf({"low", "lower end", "deg"}), "deg");
  EXPECT_EQ(HeaderLine({{"a", "first"}, {"b", "second"}}), "a,b\n");
}

}  // namespace
}  // namespace pickbed::tests
