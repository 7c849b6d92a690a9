#include "eval/benchmark/recognition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/layer.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// Ten bins of two scenarios. In the bands of 30 to 70 % with completion, two more of twenty
// instances are recalled in each bin but one.
Recognition Planted() {
  Recognition recognition;
  recognition.completions = {"none", "network"};
  for (int bin = 0; bin < 10; ++bin) {
    const std::string scenario = bin < 5 ? "deep_rod" : "deep_mug";
    const int more = bin == 9 ? 0 : 1;
    recognition.bins.push_back(
        {scenario, "none", bin, {{0, 5}, {4, 10}, {6, 10}, {5, 5}, {9, 10}}, {24, 25}, 1.0});
    recognition.bins.push_back({scenario,
                                "network",
                                bin,
                                {{0, 5}, {4 + more, 10}, {6 + more, 10}, {5, 5}, {9, 10}},
                                {24, 30},
                                2.0});
  }
  return recognition;
}

TEST(Recognition, ChangesArePairedByBinAndOfTheStatedInstances) {
  const Recognition planted = Planted();
  const RecognitionChange all = RecallChange(planted, "network", kOccludedFrom, kOccludedTo);
  EXPECT_EQ(all.reference.hits, 100);
  EXPECT_EQ(all.reference.samples, 200);
  EXPECT_EQ(all.rate.hits, 118);
  EXPECT_GT(all.difference.low, 0);
  EXPECT_LT(all.difference.high, 0.18);
  EXPECT_LT(all.p, 0.05);
  const RecognitionChange rod = RecallChange(planted, "network", 0.3, 0.5, "deep_rod");
  EXPECT_EQ(rod.reference.hits, 20);
  EXPECT_EQ(rod.rate.hits, 25);
  EXPECT_EQ(rod.rate.samples, 50);
  const RecognitionChange unchanged = RecallChange(planted, "network", 0.9, 1);
  EXPECT_EQ(unchanged.rate.hits, unchanged.reference.hits);
  EXPECT_EQ(unchanged.rate.samples, 100);
  const RecognitionChange precision = PrecisionChange(planted, "network");
  EXPECT_DOUBLE_EQ(precision.rate.rate(), 0.8);
  EXPECT_LT(precision.difference.high, 0);
}

TEST(Recognition, FilesHaveOneLinePerChangeAndPerBand) {
  const Recognition planted = Planted();
  const std::string csv = RecognitionCsv(planted);
  EXPECT_THAT(csv, HasSubstr("\nnetwork,,0.30,0.70,200,100,118,0.0900,"));
  EXPECT_THAT(csv, HasSubstr("\nnetwork,deep_rod,0.30,0.70,100,50,60,0.1000,"));
  EXPECT_THAT(RecognitionBinsCsv(planted), HasSubstr("\ndeep_mug,9,network,0.30,10,4,30,24\n"));
  EXPECT_THAT(RecognitionText(planted), HasSubstr("+9.0 ["));
}

TEST(Recognition, ChangesInAnImageAreOfVisibleInstances) {
  const auto instance = [](double visible_fraction, bool recalled) {
    InstanceRecord record;
    record.visible_fraction = visible_fraction;
    record.recalled = recalled;
    return record;
  };
  const RecalledChange change =
      ChangeInImage({instance(0.9, true), instance(0.8, false), instance(0.5, false),
                     instance(0.4, true), instance(0.05, false)},
                    {instance(0.9, true), instance(0.8, true), instance(0.5, true),
                     instance(0.4, false), instance(0.05, true)});
  EXPECT_EQ(change.instances, 4);
  EXPECT_EQ(change.recalled_before, 2);
  EXPECT_EQ(change.recalled_after, 3);
  EXPECT_EQ(change.gained, 2);
  EXPECT_EQ(change.lost, 1);
}

TEST(Recognition, ThePageShowsOverlaysSideBySide) {
  Recognition planted = Planted();
  planted.gallery.push_back({"deep_rod", 3, {30, 12, 13, 2, 1}, "a/none.png", "a/network.png"});
  HtmlPage page("Recognition");
  AddRecognition(planted, "recognition", page);
  EXPECT_THAT(page.body(), HasSubstr("deep_rod, bin 3: 2 gained, 1 lost"));
  EXPECT_THAT(page.body(), HasSubstr("none: 12 of 30 instances"));
  EXPECT_THAT(page.body(), HasSubstr("network: 13 of 30 instances"));
  EXPECT_LT(page.body().find("recognition/a/none.png"), page.body().find("a/network.png"));
}

TEST(Recognition, RemovesThePicturesOfAnEarlierBenchmark) {
  const TemporaryFolder folder;
  RecognitionOptions options;
  options.scenarios = {"deep_rod"};
  options.pictures = folder.path();
  for (const char* name : {"deep_rod_0_000", "deep_mug_3_012", "mine", "mine_1"}) {
    MakeFolder(folder.path() / name);
    WriteFileAtomically(folder.path() / name / "a.png", "");
  }
  EXPECT_TRUE(RunRecognition(options, [](int, int) { return false; }).bins.empty());
  for (const char* name : {"deep_rod_0_000", "deep_mug_3_012"}) {
    EXPECT_FALSE(std::filesystem::exists(folder.path() / name)) << name;
  }
  for (const char* name : {"mine", "mine_1"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / name / "a.png")) << name;
  }
}

TEST(Recognition, RefusesOneCompletionUnknownScenariosAndMethods) {
  const auto error_of = [](const RecognitionOptions& options) {
    return ErrorOf([&] { RunRecognition(options, {}); });
  };
  RecognitionOptions options;
  options.scenarios = {"deep_rd"};
  EXPECT_THAT(error_of(options), HasSubstr("deep_rd"));
  options.completions = {"none", "none"};
  EXPECT_THAT(error_of(options), HasSubstr("at least two completions"));
  options.completions = {"none", "skrit"};
  EXPECT_THAT(error_of(options), HasSubstr("'skirt'"));
}

}  // namespace
}  // namespace pickbed::tests
