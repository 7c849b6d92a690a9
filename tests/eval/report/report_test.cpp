#include "eval/report/report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "eval/export/pick_animation.h"
#include "eval/page/html.h"
#include "eval/store/results_store.h"
#include "eval/summary/result_files.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/support/stub_trials.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

// A results folder "a run" with stub trials.
class RunReportPageTest : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<std::filesystem::path> places = PageTemplatePlaces();
    if (std::none_of(places.begin(), places.end(),
                     [](const auto& place) { return std::filesystem::exists(place); })) {
      GTEST_SKIP() << "there is no page template";
    }
    WriteRun(run_, StubTrials(kTrials));
    options_.views = 0;  // stub trials have no scenes
    options_.page_folder = temporary_.path();
  }
  static void WriteRun(const std::filesystem::path& folder, const std::vector<TrialResult>& trials,
                       const std::string& more_identity = "") {
    MakeFolder(folder);
    const std::string scenario =
        "seed: 17\nobjects: [{name: rod, count: 6}, {name: flange, count: 6}]\n";
    WriteFileAtomically(folder / kScenarioFile, scenario);
    ResultsStore store(folder, {scenario + more_identity,
                                {{.name = "",
                                  .trials = static_cast<int>(trials.size()),
                                  .identity = scenario + more_identity,
                                  .settings = scenario}}});
    for (const TrialResult& trial : trials) store.Write(trial);
  }
  std::string Page() const { return PageOf(run_); }
  std::string PageOf(const std::filesystem::path& folder) const {
    return RunReportPage(ReadReportRun(folder), OpenCatalog("none"), options_);
  }
  std::filesystem::path PictureFile(int trial, const std::string& name) const {
    const std::filesystem::path folder = PicturesOf(run_, trial);
    MakeFolder(folder);
    return folder / name;
  }

  static constexpr int kTrials = 6;
  const TemporaryFolder temporary_;
  const std::filesystem::path run_ = temporary_.path() / "a run";
  ReportOptions options_;
};

TEST_F(RunReportPageTest, DamagedPictureIsLeftOut) {
  for (int trial = 0; trial < kTrials; ++trial) {
    for (int attempt = 0; attempt < 5; ++attempt) {
      std::ofstream(PictureFile(trial, AttemptPicture(attempt, "overlay"))) << "no picture";
    }
  }
  const std::string page = Page();
  EXPECT_THAT(page, HasSubstr("damaged files are left out"));
  EXPECT_THAT(page, Not(HasSubstr("class=\"overlay\"")));
}

TEST_F(RunReportPageTest, ComparisonNamesTheSettingsThatDiffer) {
  const std::filesystem::path other = temporary_.path() / "other";
  WriteRun(other, StubTrials(kTrials), "sensor: a<b\n");
  const auto page_of = [&](const std::filesystem::path& a, const std::filesystem::path& b) {
    return CompareRuns(ReadReportRun(a), ReadReportRun(b), OpenCatalog("none"), options_).page;
  };
  EXPECT_THAT(page_of(run_, other),
              AllOf(HasSubstr("Settings that differ"),
                    HasSubstr("<td>sensor</td><td>nothing</td><td>a&lt;b</td>")));
  const std::filesystem::path same = temporary_.path() / "same";
  WriteRun(same, StubTrials(kTrials));
  EXPECT_THAT(page_of(run_, same), HasSubstr("All settings that affect the results are equal."));
}

TEST_F(RunReportPageTest, ASweepStatesTheErrorsOfTheCell) {
  const auto text_of = [&](const std::string& name, const std::vector<std::string>& cells) {
    const std::filesystem::path folder = temporary_.path() / name;
    MakeFolder(folder);
    StoreHead head;
    for (const std::string& cell : cells) {
      const std::string settings = fmt::format(
          "objects: [{{name: rod, count: 6}}, {{name: flange, count: 6}}]\ncell: {{{}}}\n", cell);
      head.identity += settings;
      head.configurations.push_back({.number = static_cast<int>(head.configurations.size()),
                                     .name = "c" + std::to_string(head.configurations.size()),
                                     .first_trial = kTrials * int(head.configurations.size()),
                                     .trials = kTrials,
                                     .identity = settings,
                                     .settings = settings});
    }
    ResultsStore store(folder, head);
    for (size_t i = 0; i < cells.size(); ++i) {
      for (TrialResult trial : StubTrials(kTrials)) {
        trial.trial += kTrials * static_cast<int>(i);
        trial.configuration = static_cast<int>(i);
        store.Write(trial);
      }
    }
    return PageOf(folder);
  };
  EXPECT_THAT(text_of("same", {"hand_eye_mm: 2", "hand_eye_mm: 2"}),
              HasSubstr("Errors of the cell: hand_eye_mm 2."));
  EXPECT_THAT(text_of("swept", {"", "hand_eye_mm: 2"}),
              HasSubstr("Errors of the cell: c0: none; c1: hand_eye_mm 2."));
  EXPECT_THAT(text_of("exact", {"", ""}), Not(HasSubstr("Errors of the cell")));
}

TEST_F(RunReportPageTest, ShowsSuccessByLayerIfThereAreSeveral) {
  std::vector<TrialResult> trials = StubTrials(kTrials);
  const auto page_with_layers = [&](const std::string& name, int layers) {
    int attempts = 0;
    for (TrialResult& trial : trials) {
      for (AttemptRecord& attempt : trial.attempts) attempt.layer = 1 + attempts++ % layers;
    }
    WriteRun(temporary_.path() / name, trials);
    return PageOf(temporary_.path() / name);
  };
  EXPECT_THAT(page_with_layers("one", 1), Not(HasSubstr("Success by layer")));
  EXPECT_THAT(page_with_layers("two", 2), HasSubstr("Success by layer"));
}

TEST_F(RunReportPageTest, ARunWithoutPosesHasNoChartsOfPoses) {
  EXPECT_THAT(Page(), AllOf(HasSubstr("Pose error"), HasSubstr("Calibration of the score")));
  std::vector<TrialResult> trials = StubTrials(kTrials);
  for (TrialResult& trial : trials) {
    for (AttemptRecord& attempt : trial.attempts) {
      attempt.pose_free = true;
      attempt.hypotheses.clear();
      attempt.chosen = -1;
    }
  }
  const std::filesystem::path run = temporary_.path() / "pose_free";
  WriteRun(run, trials);
  const std::string page = PageOf(run);
  EXPECT_THAT(page, HasSubstr("Failed picks by reason"));
  EXPECT_THAT(page, Not(HasSubstr("Pose error")));
  EXPECT_THAT(page, Not(HasSubstr("Calibration of the score")));
}

TEST_F(RunReportPageTest, ThumbnailsAndScenarioAreLinkedRelativeToThePage) {
  const FailedPick failed = [&] {
    const ReportRun run = ReadReportRun(run_);
    return FailedPicksOf(std::vector{run.configurations[0].trials}).front();
  }();
  const std::string name = AttemptPicture(failed.attempt, "overlay");
  WritePng(PictureFile(failed.trial, name), Image<Rgb8>(64, 48, {90, 90, 90}));
  const std::string link =
      fmt::format("<a href=\"a%20run/pictures/trial_{:04}/{}\"", failed.trial, name);
  EXPECT_THAT(Page(), HasSubstr(link));
  EXPECT_THAT(Page(), HasSubstr("<a href=\"a%20run/scenario.yaml\""));
  EXPECT_THAT(Page(), HasSubstr("count: 6")) << "the settings are on the page";
  EXPECT_THAT(Page(), HasSubstr("of its volume")) << "how full the bin is";
  options_.page_folder.clear();
  EXPECT_THAT(Page(), Not(HasSubstr("<a href=\"a%20run")));
}

TEST_F(RunReportPageTest, SaysWhenTheFirstAnimatedPickIsTooLarge) {
  for (int trial = 0; trial < kTrials; ++trial) {
    for (int attempt = 0; attempt < 5; ++attempt) {
      std::ofstream(PictureFile(trial, PickAnimationName(attempt))) << std::string(20000, 'x');
    }
  }
  options_.animations_mb = 0.02;
  EXPECT_THAT(Page(), HasSubstr("No animated pick is shown, because the first one is too large"));
  options_.animations_mb = 0.04;
  EXPECT_THAT(Page(), HasSubstr("More animated picks are left out"));
}

}  // namespace
}  // namespace pickbed::tests
