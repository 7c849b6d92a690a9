#include "scenes/scenario/appearance_ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "scenes/scenario/scenario_spec.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

std::string Written(ScenarioSpec spec) {
  return WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
}

class AppearanceSettings : public ::testing::Test {
 protected:
  ScenarioSpec Load(const std::string& more, const std::vector<std::string>& set = {}) {
    return LoadScenario(folder_.Write("looks.yaml", "objects: [{name: rod}]\n" + more), set);
  }
  std::string ErrorOf(const std::string& more, const std::vector<std::string>& set = {}) {
    try {
      Load(more, set);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  const TemporaryFolder folder_;
};

TEST_F(AppearanceSettings, EveryRangeIsReadUnderItsName) {
  const ScenarioSpec spec = Load(
      "appearance:\n  lamp_x_m: [-1, -0.5]\n  lamp_y_m: [0, 1]\n  lamp_z_m: [2, 3]\n"
      "  ambient: [0.1, 0.2]\n  shadow_share: 0.3\n  shadow_softness_m: [0.004, 0.005]\n"
      "  tint: [0.6, 0.7]\n  gloss: [0.8, 0.9]\n  grain: [0.15, 0.25]\n"
      "  grain_cells_pm: [300, 400]\n  background: [0.35, 0.45]\n  background_cell_px: [5, 6]\n");
  const AppearanceRanges& a = spec.appearance;
  EXPECT_EQ(a.shadow_share, 0.3);
  const std::pair<const Span&, Span> spans[] = {
      {a.lamp_x_m, {-1, -0.5}},       {a.lamp_y_m, {0, 1}},
      {a.lamp_z_m, {2, 3}},           {a.ambient, {0.1, 0.2}},
      {a.tint, {0.6, 0.7}},           {a.shadow_softness_m, {0.004, 0.005}},
      {a.gloss, {0.8, 0.9}},          {a.grain, {0.15, 0.25}},
      {a.grain_cells_pm, {300, 400}}, {a.background, {0.35, 0.45}},
      {a.background_cell_px, {5, 6}},
  };
  for (const auto& [read, given] : spans) {
    EXPECT_EQ(read.min, given.min);
    EXPECT_EQ(read.max, given.max);
  }
  // Written ranges read back unchanged.
  ScenarioSpec copy;
  ReadSettingsText(Written(spec), "copy", [&](SettingsVisitor& v) { copy.Visit(v); });
  EXPECT_EQ(Written(copy), Written(spec));
}

TEST_F(AppearanceSettings, DefaultRangesHaveNoVariation) {
  const AppearanceRanges a = Load("").appearance;
  for (const Span& span : {a.lamp_x_m, a.lamp_y_m, a.lamp_z_m, a.ambient, a.shadow_softness_m,
                           a.tint, a.gloss, a.grain, a.background}) {
    EXPECT_EQ(span.min, span.max);
  }
  EXPECT_EQ(a.shadow_share, 0);
}

TEST_F(AppearanceSettings, ReversedRangeErrorHoldsKeyAndPlace) {
  const std::string error = ErrorOf("appearance:\n  gloss: [0.5, 0.2]\n");
  EXPECT_THAT(error, HasSubstr("looks.yaml:3: appearance.gloss = [0.5, 0.2]"));
  EXPECT_THAT(error, HasSubstr("the minimum first"));
  EXPECT_THAT(ErrorOf("", {"appearance.lamp_z_m=[2, 1]"}),
              HasSubstr("setting appearance.lamp_z_m=[2, 1]: appearance.lamp_z_m = [2, 1]"));
  EXPECT_THAT(ErrorOf("appearance: {tint: [0, 1.5]}\n"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(ErrorOf("appearance: {gloss: 0.5}\n"), HasSubstr("must be a list of 2 numbers"));
  EXPECT_THAT(ErrorOf("appearance: {glos: [0, 1]}\n"), HasSubstr("did you mean 'gloss'"));
  EXPECT_EQ(ErrorOf("appearance: {gloss: [0.2, 0.2]}\n"), "no error");
}

TEST(AppearanceRanges, PredefinedRangesAreValid) {
  EXPECT_NO_THROW(WideAppearance().Validate());
  EXPECT_NO_THROW(FixedAppearance().Validate());
  EXPECT_NO_THROW(AppearanceRanges().Validate());
  AppearanceRanges ranges;
  ranges.shadow_share = 1.5;
  EXPECT_THROW(ranges.Validate(), InputError);
  ranges = {};
  ranges.lamp_x_m = {-101, 0};
  EXPECT_THROW(ranges.Validate(), InputError);
}

}  // namespace
}  // namespace pickbed::tests
