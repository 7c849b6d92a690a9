#include "eval/benchmark/bins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "eval/summary/run_summary.h"
#include "eval/trial/oracle_estimator.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/verifier_library.h"
#include "scenes/base/files.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

BinStatistics OneBin(int trial, int recalled, int instances) {
  BinStatistics bin{trial, recalled > 0, 0.5, std::vector<Cluster>(EmptyRecallBands().size())};
  bin.bands.back() = {recalled, instances};
  return bin;
}

// Two scenarios with two bins each. With the siamese term one more instance is found in each bin.
std::vector<BinScenario> HandWorked() {
  std::vector<BinScenario> scenarios;
  for (const char* name : {"bin_a", "bin_b"}) {
    const BinRow with{"doumanoglou", {OneBin(0, 8, 10), OneBin(1, 6, 10)}, 0.5, 0.6, 100, 1};
    const BinRow without{
        "doumanoglou, no siamese term", {OneBin(0, 7, 10), OneBin(1, 5, 10)}, 0.4, 0.5, 90, 1};
    scenarios.push_back({name, {with, without}});
  }
  return scenarios;
}

TEST(BinTable, NoScenariosGiveOnlyTheHeader) {
  const std::string csv = BinTableCsv({});
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1);
}

TEST(BinTable, StatisticsEqualHandComputedValues) {
  const std::string csv = BinTableCsv(HandWorked());
  EXPECT_THAT(csv, HasSubstr("all,\"doumanoglou\",4,4,28,40,0.5000,0.6000,0.5000,100.0"));
  EXPECT_THAT(csv, HasSubstr("bin_b,\"doumanoglou, no siamese term\",2,2,12,20,0.4000"));
  EXPECT_THAT(csv, HasSubstr(",recalled_90_100,instances_90_100\n"));
  EXPECT_THAT(BinTableText(HandWorked()),
              HasSubstr("by +10.0 (too few bins) percentage points over 4 bins"));
  std::vector<BinScenario> six_bins = HandWorked();
  six_bins.push_back(six_bins[0]);
  six_bins.back().name = "bin_c";
  EXPECT_THAT(BinTableText(six_bins), HasSubstr("70.0 ["));
  EXPECT_THAT(BinTableText(six_bins), HasSubstr("by +10.0 ["));
  EXPECT_THAT(BinTablePage(HandWorked()).body(), HasSubstr("over 4 bins"));
}

TEST(BinTable, NoSiameseGainWithoutBothRegressionRows) {
  std::vector<BinScenario> scenarios = HandWorked();
  for (BinScenario& scenario : scenarios) scenario.rows.pop_back();
  EXPECT_THAT(BinTableText(scenarios), Not(HasSubstr("siamese")));
}

// Counts of chart elements on a page, from the heading "By visible fraction" to the next heading.
struct Drawn {
  int charts = 0;
  int bands = 0;       // intervals drawn as areas
  int references = 0;  // curves with data of their own
};
Drawn DrawnOn(const HtmlPage& page) {
  const std::string& body = page.body();
  const size_t begin = body.find("By visible fraction");
  const std::string section = body.substr(begin, body.find("By scenario", begin) - begin);
  const auto count = [&](const std::string& text) {
    int found = 0;
    for (size_t at = section.find(text); at != section.npos; at = section.find(text, at + 1))
      ++found;
    return found;
  };
  const int charts = count("class=\"plot\"");
  return {charts, count("\"type\":\"area\""), count("\"data\":{\"values\"") - charts};
}

TEST(BinTable, EachChartShowsOneEstimatorAndTheReference) {
  std::vector<BinScenario> scenarios = HandWorked();
  const Drawn without = DrawnOn(BinTablePage(scenarios));
  EXPECT_EQ(without.charts, 2);
  EXPECT_EQ(without.references, 0);
  EXPECT_THAT(BinTablePage(scenarios).body(), Not(HasSubstr("Grey")));
  for (BinScenario& scenario : scenarios) {
    scenario.rows.push_back(scenario.rows.front());
    scenario.rows.back().label = "descriptor:accurate";
  }
  const Drawn with = DrawnOn(BinTablePage(scenarios));
  EXPECT_EQ(with.charts, 3);
  EXPECT_EQ(with.bands, 3);
  EXPECT_EQ(with.references, 2);
  EXPECT_THAT(BinTablePage(scenarios).body(), HasSubstr("Grey: descriptor:accurate"));
}

TEST(BinTable, NoteAppearsInTextAndPage) {
  EXPECT_THAT(BinTableText(HandWorked(), "Small form."), HasSubstr("\nSmall form.\n"));
  EXPECT_THAT(BinTablePage(HandWorked(), "Small form.").body(), HasSubstr("<p>Small form.</p>"));
}

TEST(BinTable, ScenarioColumnsOmitThePrefix) {
  EXPECT_THAT(BinTablePage(HandWorked()).body(),
              HasSubstr("<th class=\"n\">a</th><th class=\"n\">b</th>"));
}

TEST(BinScenarioFile, RoundTripAndRejectionOfOtherKeyOrDamage) {
  const TemporaryFolder temporary;
  const std::filesystem::path file = temporary.path() / "bin_a.json";
  EXPECT_FALSE(ReadBinScenario(file, "key"));
  const BinScenario scenario = HandWorked()[0];
  WriteBinScenario(file, scenario, "key");
  const auto read = ReadBinScenario(file, "key");
  ASSERT_TRUE(read);
  EXPECT_EQ(BinTableCsv({*read}), BinTableCsv({scenario}));
  EXPECT_FALSE(ReadBinScenario(file, "other key"));
  const std::string bytes = ReadFileBytes(file);
  WriteFileAtomically(file, bytes.substr(0, bytes.size() / 2));
  EXPECT_FALSE(ReadBinScenario(file, "key"));
}

TEST(SharedBins, SharesDifferByAtMostOneAndAreNeverZero) {
  EXPECT_EQ(SharedBins(10, 3), (std::vector<int>{4, 3, 3}));
  EXPECT_EQ(SharedBins(10, 5), (std::vector<int>{2, 2, 2, 2, 2}));
  EXPECT_EQ(SharedBins(2, 3), (std::vector<int>{1, 1, 1}));
}

TEST(BinMethods, EachMethodNamesAnEstimatorAndItsTraining) {
  std::set<std::string> labels;
  for (const BinMethod& method : BinMethods()) {
    EXPECT_NO_THROW(RequireEstimator(method.estimator));
    EXPECT_TRUE(labels.insert(method.label).second) << method.label;
    EXPECT_EQ(std::string(method.model).empty(), method.training.empty()) << method.label;
    if (method.training.empty()) continue;
    EXPECT_THAT(TrainingWords(method, "folder/a.net", EasyCube(), false),
                testing::IsSupersetOf(
                    {std::string("--objects"), EasyCube()[0]->name, std::string("folder/a.net")}));
    // --small inserts further settings before the other arguments of a full training.
    EXPECT_EQ(
        TrainingWords(method, "a.net", EasyCube(), true).size(),
        TrainingWords(method, "a.net", EasyCube(), false).size() + method.small_training.size());
    // No model was trained for the cube.
    EXPECT_TRUE(FindBinModel(method, "no such folder", EasyCube(), false).empty()) << method.label;
  }
}

const BinMethod& MethodNamed(const std::string& label) {
  return *std::ranges::find(BinMethods(), label, [](const BinMethod& m) { return m.label; });
}

// Saves the verifiers of the shipped file. Their first object gets the name and the mesh hash of
// `object`.
void SaveModelOf(const ObjectModel& object, const std::filesystem::path& file) {
  VerifierFile known = LoadVerifiers(AssetsDir() / "models/ppf.net", "ppf");
  known.objects.front().name = object.name;
  known.objects.front().mesh_hash = object.mesh_hash;
  SaveVerifiers(file, known);
}

// No file can be mistaken for another: not for one trained with --small, for other objects or for
// another mesh.
TEST(TrainedModelFile, EachTrainingHasItsOwnFile) {
  const BinMethod& method = MethodNamed("kehl");
  const ObjectSet cube = EasyCube();
  auto changed = std::make_shared<ObjectModel>(*cube[0]);
  changed->mesh_hash += 1;
  const std::set<std::filesystem::path> files{
      TrainedModelFile(method, "folder", cube, false),
      TrainedModelFile(method, "folder", cube, true),
      TrainedModelFile(method, "folder", {changed}, false),
      TrainedModelFile(method, "folder", {cube[0], changed}, false),
      TrainedModelFile(MethodNamed("doumanoglou"), "folder", cube, false)};
  EXPECT_EQ(files.size(), 5u);
  EXPECT_EQ(TrainedModelFile(MethodNamed("union"), "folder", cube, false),
            TrainedModelFile(MethodNamed("doumanoglou"), "folder", cube, false))
      << "they share a model";
}

TEST(FindBinModel, UsersModelTakesPrecedenceOverTrainedModel) {
  const BinMethod& method = MethodNamed("ppf:verified");
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  const ObjectSet cube = EasyCube();
  const std::filesystem::path trained = TrainedModelFile(method, folder, cube, false),
                              own = folder / "ppf.net";
  // A stopped training leaves a file from which it can resume. That file is not yet a model.
  SaveModelOf(*cube[0], UnfinishedLibrary(trained));
  EXPECT_TRUE(FindBinModel(method, folder, cube, false).empty());
  EXPECT_TRUE(IsBegun(trained));
  std::filesystem::rename(UnfinishedLibrary(trained), trained);
  EXPECT_FALSE(IsBegun(trained));
  EXPECT_EQ(FindBinModel(method, folder, cube, false), trained);
  SaveModelOf(*cube[0], own);
  EXPECT_EQ(FindBinModel(method, folder, cube, false), own);
  auto changed = std::make_shared<ObjectModel>(*cube[0]);
  changed->mesh_hash += 1;
  EXPECT_TRUE(FindBinModel(method, folder, {changed}, false).empty());
  temporary.Write("kehl.net.checkpoint", "");
  EXPECT_TRUE(IsBegun(folder / "kehl.net"));
}

TEST(BinRowOf, CopiesTheStatisticsOfAComparison) {
  ScenarioSpec spec = CubeScenario(3);
  spec.trials = 2;
  const ComparisonJob job{spec, EasyCube(), {{"oracle", spec.estimator}}, {}, 0, 1, {}, {}};
  const BinRow row = BinRowOf(CompareEstimators(job).front());
  ASSERT_EQ(row.bins.size(), 2u);
  for (const BinStatistics& bin : row.bins) {
    EXPECT_TRUE(bin.top_right);
    EXPECT_EQ(SumOf(bin.bands).hits, SumOf(bin.bands).samples);
    EXPECT_EQ(SumOf(bin.bands).samples, 3);
  }
  EXPECT_NEAR(row.ap, 1, 1e-9);
}

}  // namespace
}  // namespace pickbed::tests
