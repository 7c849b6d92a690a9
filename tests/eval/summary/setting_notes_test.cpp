#include "eval/summary/setting_notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/settings.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// A scenario of cubes with these settings from the command line.
ScenarioSpec With(const std::vector<std::string>& settings) {
  ScenarioSpec spec = CubeScenario(1);
  for (const std::string& setting : settings) {
    for (const auto& [key, place] :
         ApplySetting(setting, [&](SettingsVisitor& v) { spec.Visit(v); })) {
      spec.places[key] = place;
    }
  }
  return spec;
}

TEST(UnusedSettings, NamesEachSettingThatChangesNothing) {
  EXPECT_EQ(UnusedSettings(With({})), "");
  EXPECT_EQ(UnusedSettings(With({"estimator.mode=first"})),
            "note: setting estimator.mode=first is not used: the oracle takes poses from the "
            "scene\n");
  EXPECT_EQ(UnusedSettings(With({"policy.stir.after_failures=3"})),
            "note: setting policy.stir.after_failures=3 is not used: policy.stir.max is 0\n");
  EXPECT_EQ(UnusedSettings(With({"estimator.model=a.net"})),
            "note: setting estimator.model=a.net is not used: the oracle takes poses from the "
            "scene\n");
  EXPECT_THAT(UnusedSettings(With({"policy.stir.max=3", "policy.stop=one_pick"})),
              HasSubstr("policy.stir.max=3 is not used"));
  EXPECT_THAT(UnusedSettings(With({"policy.tolerance_maps=maps"})),
              HasSubstr("policy.ranking is quality"));
  EXPECT_THAT(UnusedSettings(With({"planner.name=cloud_antipodal", "estimator.name=ppf"})),
              HasSubstr("planner cloud_antipodal works without poses"));
}

TEST(UnusedSettings, DoesNotNameSettingsThatAreUsed) {
  EXPECT_EQ(UnusedSettings(With({"policy.stir.max=3", "policy.stir.after_failures=2"})), "");
  EXPECT_EQ(UnusedSettings(With({"estimator.name=ppf", "estimator.mode=verified"})), "");
  EXPECT_EQ(UnusedSettings(With({"policy.ranking=tolerance", "policy.tolerance_maps=maps"})), "");
  EXPECT_EQ(UnusedSettings(With({"policy.check_lift=true", "policy.lift_clearance_mm=2"})), "");
}

TEST(NeedsPoses, NamesThePlaceOfAnUnknownPlanner) {
  EXPECT_THAT(ErrorOf([] { NeedsPoses(With({"planner.name=x"})); }),
              testing::StartsWith("setting planner.name=x: planner.name: unknown planner 'x'"));
}

// The file of a preset has settings for its own estimator.
TEST(UnusedSettings, DoesNotNameSettingsOfTheFile) {
  ScenarioSpec spec = CubeScenario(1);
  spec.places["estimator.mode"] = "bin.yaml:14";
  EXPECT_EQ(UnusedSettings(spec), "");
}

TEST(SmallObjectNote, IsGivenBelowTwentyPixels) {
  ScenarioSpec spec = CubeScenario(1);
  EXPECT_EQ(SmallObjectNote(spec, EasyCube()), "");
  spec.camera.focal_px = 40;
  EXPECT_THAT(SmallObjectNote(spec, EasyCube()),
              testing::AllOf(testing::StartsWith("note: camera.eye_m"), HasSubstr("'cube' is")));
  spec.objects[0].distractor = true;
  EXPECT_EQ(SmallObjectNote(spec, EasyCube()), "") << "no estimator looks for it";
}

}  // namespace
}  // namespace pickbed::tests
