#include "scenes/scenario/planner_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/scenario/scenario_spec.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

constexpr char kScenario[] = "objects:\n  - {name: rod, count: 1}\n";

TEST(PlannerSpec, AScenarioWithoutTheGroupPlansOnPoses) {
  EXPECT_EQ(LoadScenarioText(kScenario, ".", "s.yaml").planner.name, kPosePlanner);
  const ScenarioSpec spec = LoadScenarioText(
      std::string(kScenario) + "planner: {name: cloud_antipodal, max_tilt_deg: 20}\n", ".",
      "s.yaml");
  EXPECT_EQ(spec.planner.name, "cloud_antipodal");
  EXPECT_EQ(spec.planner.max_tilt_deg, 20);
}

TEST(PlannerSpec, ValuesOutOfRangeAreRefused) {
  const auto error = [](const std::string& group) {
    return ErrorOf(
        [&] { LoadScenarioText(std::string(kScenario) + "planner: " + group, ".", "s.yaml"); });
  };
  EXPECT_THAT(error("{friction: 0}"), HasSubstr("s.yaml:3: planner.friction"));
  EXPECT_THAT(error("{max_tilt_deg: 90}"), HasSubstr("planner.max_tilt_deg"));
  EXPECT_THAT(error("{rehearsals: -1}"), HasSubstr("s.yaml:3: planner.rehearsals"));
  EXPECT_THAT(error("{nam: poses}"), HasSubstr("name"));
}

TEST(PlannerSpec, ThePortOfAServerIsCheckedWhenTheSettingIsRead) {
  for (const std::string role : {"planner", "estimator"}) {
    const auto error = [&](const std::string& address) {
      return ErrorOf([&] {
        LoadScenarioText(kScenario + role + ":\n  connect: '" + address + "'\n", ".", "s.yaml");
      });
    };
    EXPECT_THAT(error("gpu:99999"),
                HasSubstr("s.yaml:4: " + role + ".connect: 'gpu:99999' is no address"));
    EXPECT_THAT(error("gpu"), HasSubstr("write host:port with a port from 1 to 65535"));
    EXPECT_EQ(error("gpu:5555"), "no error");
  }
}

}  // namespace
}  // namespace pickbed::tests
