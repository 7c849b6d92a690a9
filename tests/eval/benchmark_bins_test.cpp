#include "eval/benchmark_bins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "eval/oracle.h"
#include "eval/summary.h"
#include "perception/torch_verifier_file.h"
#include "scenes/files.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

using testing::HasSubstr;
using testing::Not;

BinLook Look(int trial, int recalled, int instances) {
  BinLook look{trial, recalled > 0, 0.5, std::vector<Cluster>(EmptyRecallBands().size())};
  look.bands.back() = {recalled, instances};
  return look;
}

// Two scenarios of two bins; the siamese term finds one part more in each bin.
std::vector<BinScenario> HandWorked() {
  std::vector<BinScenario> scenarios;
  for (const char* name : {"bin_a", "bin_b"}) {
    const BinRow with{"doumanoglou", {Look(0, 8, 10), Look(1, 6, 10)}, 0.5, 0.6, 100, 1};
    const BinRow without{
        "doumanoglou, no siamese term", {Look(0, 7, 10), Look(1, 5, 10)}, 0.4, 0.5, 90, 1};
    scenarios.push_back({name, {with, without}});
  }
  return scenarios;
}

TEST(BinTable, FiguresByHand) {
  const std::string csv = BinTableCsv(HandWorked());
  EXPECT_THAT(csv, HasSubstr("all,\"doumanoglou\",4,4,28,40,0.5000,0.6000,0.5000,100.0"));
  EXPECT_THAT(csv, HasSubstr("bin_b,\"doumanoglou, no siamese term\",2,2,12,20,0.4000"));
  EXPECT_THAT(csv, HasSubstr(",recalled_90_100,instances_90_100\n"));
  EXPECT_THAT(BinTableText(HandWorked()), HasSubstr("70.0 ["));
  EXPECT_THAT(BinTableText(HandWorked()), HasSubstr("by +10.0 points, 95 % interval ["));
  EXPECT_THAT(BinTablePage(HandWorked()), HasSubstr("over 4 bins"));
}

TEST(BinTable, WithoutBothRegressionsNothingIsSaidOfTheGain) {
  std::vector<BinScenario> scenarios = HandWorked();
  for (BinScenario& scenario : scenarios) scenario.rows.pop_back();
  EXPECT_THAT(BinTableText(scenarios), Not(HasSubstr("siamese")));
}

// Pieces of the drawings of a page by visible fraction, from its heading to the table below.
struct Drawn {
  int charts = 0;
  int intervals = 0;   // one a chart
  int references = 0;  // curves without one
};
Drawn DrawnOn(const std::string& page) {
  const size_t begin = page.find("By visible fraction");
  const std::string part = page.substr(begin, page.find("<table>", begin) - begin);
  const auto count = [&](const std::string& text) {
    int found = 0;
    for (size_t at = part.find(text); at != part.npos; at = part.find(text, at + 1)) ++found;
    return found;
  };
  return {count("<svg"), count("<polygon"), count("<polyline") - count("<polygon")};
}

TEST(BinTable, DrawsEachEstimatorAloneOverTheReference) {
  std::vector<BinScenario> scenarios = HandWorked();
  const Drawn without = DrawnOn(BinTablePage(scenarios));
  EXPECT_EQ(without.charts, 2);
  EXPECT_EQ(without.references, 0);
  EXPECT_THAT(BinTablePage(scenarios), Not(HasSubstr("Grey")));
  for (BinScenario& scenario : scenarios) {
    scenario.rows.push_back(scenario.rows.front());
    scenario.rows.back().label = "descriptor:hard";
  }
  const Drawn with = DrawnOn(BinTablePage(scenarios));
  EXPECT_EQ(with.charts, 3);
  EXPECT_EQ(with.intervals, 3);
  EXPECT_EQ(with.references, 2);
  EXPECT_THAT(BinTablePage(scenarios), HasSubstr("Grey: descriptor:hard"));
}

TEST(BinTable, SaysWhatItIsToldToSay) {
  EXPECT_THAT(BinTableText(HandWorked(), "Small form."), HasSubstr("\nSmall form.\n"));
  EXPECT_THAT(BinTablePage(HandWorked(), "Small form."), HasSubstr("<p>Small form.</p>"));
}

TEST(BinTable, ScenariosAreColumnsWithoutTheirPrefix) {
  EXPECT_THAT(BinTablePage(HandWorked()), HasSubstr("<th>a</th><th>b</th>"));
}

TEST(BinScenarioFile, SurvivesTheRoundTripAndIsDoneAgainWhereItDoesNotFit) {
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

TEST(SharedBins, SumToAllOfThemAndDifferByOneButAreNeverNone) {
  EXPECT_EQ(SharedBins(10, 3), (std::vector<int>{4, 3, 3}));
  EXPECT_EQ(SharedBins(10, 5), (std::vector<int>{2, 2, 2, 2, 2}));
  EXPECT_EQ(SharedBins(2, 3), (std::vector<int>{1, 1, 1}));
}

TEST(BinMethods, AreEstimatorsAndKnowHowTheirModelsAreMade) {
  std::set<std::string> labels;
  for (const BinMethod& method : BinMethods()) {
    EXPECT_NO_THROW(RequireEstimator(method.estimator));
    EXPECT_TRUE(labels.insert(method.label).second) << method.label;
    EXPECT_EQ(std::string(method.model).empty(), method.training.empty()) << method.label;
    if (method.training.empty()) continue;
    EXPECT_THAT(TrainingWords(method, "folder", {"rod", "ring"}),
                testing::IsSupersetOf({std::string("--objects"), std::string("rod,ring"),
                                       "folder/" + std::string(method.model) + ".pt"}));
    // Of --small: further settings, so that they go before those of a full training.
    EXPECT_EQ(TrainingWords(method, "folder", {"rod"}, true).size(),
              TrainingWords(method, "folder", {"rod"}).size() + method.small_training.size());
    // A cube is in no model.
    EXPECT_TRUE(FindBinModel(method, "no such folder", EasyCube(), {}).empty()) << method.label;
  }
}

// What a model was trained by decides whether it is taken, gone on with or trained anew.
TEST(FindBinModel, TakesTheUsersModelAndThatOfTheSameTrainingAlone) {
  const BinMethod& method = *std::ranges::find(BinMethods(), std::string("ppf:verified"),
                                               [](const BinMethod& m) { return m.label; });
  const TemporaryFolder temporary;
  const std::filesystem::path folder = temporary.path(), file = folder / "ppf.pt";
  const ObjectSet cube = EasyCube();
  const std::vector<std::string> words = TrainingWords(method, folder, {"cube"}),
                                 others = TrainingWords(method, folder, {"cube", "rod"});
  EXPECT_FALSE(WasBegun(method, folder, words));
  VerifierFile known = LoadVerifiers(AssetsDir() / "models/ppf.pt", "ppf");
  known.objects.front().name = cube[0]->name;
  known.objects.front().mesh_hash = cube[0]->mesh_hash;
  SaveVerifiers(file, known);
  EXPECT_EQ(FindBinModel(method, folder, cube, words), file) << "the user's own";
  EXPECT_FALSE(WasBegun(method, folder, words));
  WriteTrainingCommand(method, folder, words);
  EXPECT_EQ(FindBinModel(method, folder, cube, words), file);
  EXPECT_TRUE(FindBinModel(method, folder, cube, others).empty());
  EXPECT_TRUE(WasBegun(method, folder, words));
  EXPECT_FALSE(WasBegun(method, folder, others));
}

TEST(BinRowOf, TakesTheFiguresOfAComparison) {
  ScenarioSpec spec = CubeScenario(3);
  spec.trials = 2;
  const ComparisonJob job{spec, EasyCube(), {{"oracle", spec.estimator}}, {}, 0, 1, {}, {}};
  const BinRow row = BinRowOf(CompareEstimators(job).front());
  ASSERT_EQ(row.looks.size(), 2u);
  for (const BinLook& look : row.looks) {
    EXPECT_TRUE(look.top_right);
    EXPECT_EQ(SumOf(look.bands).hits, SumOf(look.bands).tries);
    EXPECT_EQ(SumOf(look.bands).tries, 3);
  }
  EXPECT_NEAR(row.ap, 1, 1e-9);
}

}  // namespace
}  // namespace pickbed
