#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "scenes/base/settings.h"
#include "scenes/scenario/scenario_spec.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct CheckedItem {
  int count = 1;
  void Visit(SettingsVisitor& v) { v.Integer("count", count, {1, 10}, "how many"); }
};

struct CheckedSample {
  double wall_m = 0.006;
  std::string mode = "fast";
  std::string name;
  Eigen::Vector2d size_m{1, 2};
  std::vector<CheckedItem> items{2};
  void Visit(SettingsVisitor& v) {
    v.Group(
        "bin",
        [this](SettingsVisitor& g) {
          g.Real("wall_m", wall_m, {0.001, 0.05}, "wall, m");
        },
        "bin");
    v.Text("mode", mode, {"fast", "accurate"}, "mode");
    v.Text("name", name, {}, "any text");
    v.Vector2("size_m", size_m, {0, 10}, "size, m");
    v.List(
        "items", items.size(), [this](size_t n) { items.assign(n, {}); },
        [this](size_t i, SettingsVisitor& item) { items[i].Visit(item); }, "items");
  }
};

TEST(SettingsCheck, AllFaultsAreNamedInOneLine) {
  CheckedSample sample;
  EXPECT_NO_THROW(CheckSettings("sample", sample));
  sample.wall_m = std::numeric_limits<double>::quiet_NaN();
  sample.mode = "fats";
  sample.size_m[1] = -3;
  sample.items[1].count = 11;
  EXPECT_EQ(ErrorOf([&] { CheckSettings("sample", sample); }),
            "sample: bin.wall_m = nan: must be a number from 0.001 to 0.05 (wall, m); "
            "unknown mode 'fats'; did you mean 'fast'? known: fast, accurate; "
            "size_m = -3: must be a number from 0 to 10 (size, m); "
            "items.1.count = 11: must be a number from 1 to 10 (how many)");
}

TEST(SettingsCheck, EndsOfARangeAreAllowed) {
  CheckedSample sample;
  sample.wall_m = 0.001;
  sample.items[0].count = 10;
  sample.size_m = {0, 10};
  EXPECT_NO_THROW(CheckSettings("sample", sample));
}

TEST(SettingsCheck, FaultsHaveTheWordsOfTheFileReader) {
  CheckedSample sample;
  const auto text_of = [&](const std::string& yaml) {
    CheckedSample read;
    return ErrorOf(
        [&] { ReadSettingsText(yaml, "cell.yaml", [&](SettingsVisitor& v) { read.Visit(v); }); });
  };
  sample.wall_m = 7;
  EXPECT_EQ(text_of("bin: {wall_m: 7}"),
            "cell.yaml:1: " + ErrorOf([&] { CheckSettings("s", sample); }).substr(3));
  sample = {};
  sample.mode = "slow";
  EXPECT_EQ(text_of("mode: slow"),
            "cell.yaml:1: " + ErrorOf([&] { CheckSettings("s", sample); }).substr(3));
}

TEST(SettingsCheck, NamesOfKeysCanBeGiven) {
  CheckedSample sample;
  sample.items[0].count = 0;
  EXPECT_THAT(SettingFaults([&](SettingsVisitor& v) { sample.Visit(v); },
                            [](const std::string& key) { return "cell.yaml:4: " + key; }),
              ElementsAre("cell.yaml:4: items.0.count = 0: must be a number from 1 to 10 (how "
                          "many)"));
}

TEST(SettingsCheck, AScenarioFilledInCodeIsValidated) {
  ScenarioSpec spec;
  spec.objects.resize(1);
  spec.objects[0].name = "rod";
  const ScenarioSpec valid = spec;
  EXPECT_NO_THROW(spec.Validate());
  spec.camera.width = 0;
  spec.policy.max_failures_in_row = -1;
  spec.objects[0].count = 0;
  const std::string error = ErrorOf([&] { spec.Validate(); });
  EXPECT_THAT(error, HasSubstr("camera.width = 0: must be a number from 32 to 4096"));
  EXPECT_THAT(error, HasSubstr("objects.0.count = 0: must be a number from 1 to 1000"));
  EXPECT_THAT(error, HasSubstr("policy.max_failures_in_row = -1: must be a number from "));
  spec = valid;
  spec.occlusion.margin = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf([&] { spec.Validate(); }), HasSubstr("occlusion.margin = nan: "));
  EXPECT_THAT(ErrorOf([&] { spec.occlusion.Validate(); }), HasSubstr("margin = nan: "));
}

}  // namespace
}  // namespace pickbed::tests
