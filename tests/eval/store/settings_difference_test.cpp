#include "eval/store/settings_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/store/results_store.h"
#include "tests/support/error_of.h"
#include "tests/support/layer.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr const char* kBefore =
    "seed: 1\nestimator:\n  name: descriptor\n  mode: fast\nobjects:\n  - name: rod\n    count: 5\n"
    "  - name: nut\n    count: 2\nsensor: structured_light\n# part rod is 0123\n# model 4567\n";

std::string Changed(const std::string& was, const std::string& is) {
  std::string text = kBefore;
  text.replace(text.find(was), was.size(), is);
  return text;
}

TEST(SettingsDifferences, NameKeyAndBothValues) {
  EXPECT_THAT(SettingsDifferences(kBefore, kBefore), IsEmpty());
  EXPECT_THAT(SettingsDifferences(kBefore, Changed("mode: fast", "mode: accurate")),
              ElementsAre("estimator.mode: fast before, accurate now"));
  EXPECT_THAT(SettingsDifferences(kBefore, Changed("count: 2", "count: 3")),
              ElementsAre("objects.1.count: 2 before, 3 now"));
  EXPECT_THAT(SettingsDifferences(kBefore, Changed("sensor: structured_light\n", "")),
              ElementsAre("sensor: structured_light before, nothing now"));
}

TEST(DifferentSettings, HaveKeyAndBothValues) {
  EXPECT_THAT(DifferentSettings(kBefore, kBefore), IsEmpty());
  const auto mode = DifferentSettings(kBefore, Changed("mode: fast", "mode: accurate"));
  ASSERT_EQ(mode.size(), 1u);
  EXPECT_EQ(mode[0].key, "estimator.mode");
  EXPECT_EQ(mode[0].before, "fast");
  EXPECT_EQ(mode[0].now, "accurate");
  EXPECT_EQ(SettingInWords(mode[0].key), "estimator.mode");
  const auto model = DifferentSettings(kBefore, Changed("4567", "9999"));
  ASSERT_EQ(model.size(), 1u);
  EXPECT_EQ(SettingInWords(model[0].key), "trained model");
}

TEST(SettingsDifferences, HashesAreNamedByWhatTheyDescribe) {
  EXPECT_THAT(SettingsDifferences(kBefore, Changed("0123", "9999")),
              ElementsAre("mesh or mass of object rod has changed"));
  EXPECT_THAT(SettingsDifferences(kBefore, Changed("4567", "9999")),
              ElementsAre("trained model has changed"));
  const auto difference = [](const std::string& was, const std::string& is) {
    return SettingsDifferences(kBefore + was, kBefore + is);
  };
  EXPECT_THAT(difference("# calibration 01\n", "# calibration 02\n"),
              ElementsAre("calibration of the scores has changed"));
  EXPECT_THAT(difference("# completion 01\n", "# completion 02\n"),
              ElementsAre("model of shape completion has changed"));
  EXPECT_THAT(difference("# program 01\n", "# program 02\n"),
              ElementsAre("program of the estimator or planner has changed"));
  EXPECT_THAT(difference("# cameras of the dataset 01\n", "# cameras of the dataset 02\n"),
              ElementsAre("list of the cameras has changed"));
  EXPECT_THAT(difference("# mask 01\n", "# mask 02\n"),
              ElementsAre("mask of the region of interest has changed"));
  EXPECT_THAT(difference("# task is detection\n", "# task is localisation\n"),
              ElementsAre("task: detection before, localisation now"));
  EXPECT_THAT(difference("# planner 'mine' version '1'\n", "# planner 'mine' version '2'\n"),
              ElementsAre("program that answers for the planner has changed"));
}

TEST(SettingsDifferences, GraspsOfACallerAreASentence) {
  const std::string own = std::string(kBefore) + "# grasps chosen by a caller\n";
  EXPECT_THAT(SettingsDifferences(own, kBefore),
              ElementsAre("the stored run has grasps of a caller, this one has none"));
  EXPECT_THAT(SettingsDifferences(kBefore, own),
              ElementsAre("this run has grasps of a caller, the stored one has none"));
}

// A run that is continued with another setting says which one.
TEST(ResultsStore, OtherSettingsAreNamed) {
  const TemporaryFolder folder;
  {
    ResultsStore store(folder.path(), kBefore);
    store.Write(TrialResult());
  }
  EXPECT_THAT(
      ErrorOf([&] { ResultsStore(folder.path(), Changed("mode: fast", "mode: accurate")); }),
      testing::HasSubstr("other settings (estimator.mode: fast before, accurate now); choose"));
}

}  // namespace
}  // namespace pickbed::tests
