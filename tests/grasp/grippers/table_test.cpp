#include "grasp/grippers/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "grasp/grippers/parallel_jaw.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/base/error.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// Writes a gripper file, which exists until the next call.
std::filesystem::path YamlWith(const std::string& text) {
  static std::unique_ptr<TemporaryFolder> folder;
  folder = std::make_unique<TemporaryFolder>();
  return folder->Write("gripper.yaml", text);
}

std::string LoadErrorOf(const std::string& name_or_path) {
  try {
    LoadGripper(name_or_path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Gripper, EveryShippedGripperLoadsAndOpensForAnObject) {
  ASSERT_FALSE(GripperNames().empty());
  for (const std::string& name : GripperNames()) {
    const auto gripper = LoadGripper(name);
    EXPECT_EQ(gripper->name, name);
    EXPECT_TRUE(gripper->ApproachOpening_m(0.02)) << name;
  }
}

TEST(Gripper, RowsCreateTheNamedMechanism) {
  for (const GripperRow& row : GripperTable()) {
    EXPECT_STREQ(row.make()->mechanism(), row.name);
    EXPECT_NO_THROW(row.make()->Validate("defaults")) << row.name;
  }
}

// The cache of grasp candidates and the identity of runs contain this text. A changed byte makes
// stored candidates and results unusable.
TEST(Gripper, SettingsTextIsUnchanged) {
  EXPECT_EQ(ParallelJaw().SettingsText(),
            "mechanism: \"parallel_jaw\"\n"
            "finger_size_m: [0.01, 0.02, 0.05]\n"
            "palm_size_m: [0.1, 0.04, 0.03]\n"
            "stroke_m: 0.08\n"
            "finger_mass_kg: 0.2\n"
            "force_n: 40\n"
            "close_speed_mps: 0.1\n"
            "yield_n: 40\n"
            "pad_friction: 1\n"
            "approach_m: 0.12\n"
            "clearance_m: 0.003\n");
  EXPECT_EQ(SuctionCup().SettingsText(),
            "mechanism: \"suction_cup\"\n"
            "radius_m: 0.015\n"
            "bellows_travel_m: 0.008\n"
            "press_m: 0.003\n"
            "bellows_npm: 300\n"
            "lip_conform_m: 0.0015\n"
            "vacuum_n: 45\n"
            "moment_limit_nm: 0.6\n"
            "friction: 0.8\n"
            "break_after_s: 0.02\n"
            "stem_radius_m: 0.012\n"
            "stem_length_m: 0.1\n"
            "palm_size_m: [0.06, 0.06, 0.04]\n"
            "approach_m: 0.12\n"
            "clearance_m: 0.003\n");
}

TEST(Gripper, SettingsTextReadsBackAsTheSameGripper) {
  for (const std::string& name : GripperNames()) {
    const std::string text = LoadGripper(name)->SettingsText();
    EXPECT_EQ(LoadGripper(YamlWith(text).string())->SettingsText(), text) << name;
  }
}

TEST(Gripper, FileOverridesDefaultsAndKeepsTheRest) {
  const auto loaded = LoadGripper(YamlWith("stroke_m: 0.06\nforce_n: 12.5\n").string());
  const auto& gripper = dynamic_cast<const ParallelJaw&>(*loaded);
  EXPECT_EQ(gripper.name, "gripper");
  EXPECT_EQ(gripper.hand.stroke_m, 0.06);
  EXPECT_EQ(gripper.hand.force_n, 12.5);
  EXPECT_EQ(gripper.hand.finger_mass_kg, HandSpec{}.finger_mass_kg);
}

TEST(Gripper, UnknownNameErrorSuggestsTheNearest) {
  EXPECT_THAT(LoadErrorOf("jaw_8cn"), HasSubstr("did you mean 'jaw_8cm'"));
}

TEST(Gripper, UnknownMechanismErrorSuggestsTheNearest) {
  EXPECT_THAT(LoadErrorOf(YamlWith("mechanism: parallel_jaws\n").string()),
              HasSubstr("did you mean 'parallel_jaw'"));
}

TEST(Gripper, ForceMustBePositive) {
  const auto file = YamlWith("stroke_m: 0.08\nforce_n: 0\n");
  EXPECT_THAT(LoadErrorOf(file.string()), HasSubstr(file.string() + ":2: force_n = 0"));
}

TEST(Gripper, SizesMustBePositive) {
  EXPECT_THAT(LoadErrorOf(YamlWith("finger_size_m: [0.01, -0.02, 0.05]\n").string()),
              HasSubstr("finger_size_m"));
}

TEST(Gripper, PalmMustCarryTheOpenFingers) {
  EXPECT_THAT(LoadErrorOf(YamlWith("stroke_m: 0.14\n").string()), HasSubstr("palm_size_m"));
}

TEST(Gripper, ClearanceMustLeaveStroke) {
  EXPECT_THAT(LoadErrorOf(YamlWith("stroke_m: 0.02\nclearance_m: 0.01\n").string()),
              HasSubstr("clearance_m"));
}

TEST(Gripper, ApproachOpeningIsWidthPlusClearanceUpToTheStroke) {
  ParallelJaw gripper;
  gripper.hand.stroke_m = 0.08;
  gripper.clearance_m = 0.003;
  EXPECT_DOUBLE_EQ(gripper.ApproachOpening_m(0.05).value(), 0.056);
  EXPECT_TRUE(gripper.ApproachOpening_m(0.0739));
  EXPECT_FALSE(gripper.ApproachOpening_m(0.0741));
}

TEST(Gripper, CupFilesHaveOnlyCupKeys) {
  const auto loaded = LoadGripper("cup_30mm");
  EXPECT_EQ(dynamic_cast<const SuctionCup&>(*loaded).cup.radius_m, 0.015);
  EXPECT_THAT(LoadErrorOf(YamlWith("mechanism: suction_cup\nstroke_m: 0.08\n").string()),
              HasSubstr("stroke_m"));
  EXPECT_THAT(LoadErrorOf(YamlWith("vacuum_n: 45\n").string()), HasSubstr("vacuum_n"));
}

TEST(Gripper, InvalidCupFilesAreRefused) {
  const std::string cup = "mechanism: suction_cup\n";
  EXPECT_THAT(LoadErrorOf(YamlWith(cup + "vacuum_n: 0\n").string()), HasSubstr(":2: vacuum_n = 0"));
  EXPECT_THAT(LoadErrorOf(YamlWith(cup + "radius_m: -0.01\n").string()),
              HasSubstr("radius_m = -0.01"));
  EXPECT_THAT(LoadErrorOf(YamlWith(cup + "press_m: 0.009\n").string()),
              HasSubstr("bellows_travel_m"));
  // The air pressure on a lip with radius 15 mm exerts 71.6 N.
  EXPECT_THAT(LoadErrorOf(YamlWith(cup + "vacuum_n: 73\n").string()), HasSubstr("71.6 N"));
  EXPECT_THAT(LoadErrorOf(YamlWith(cup + "moment_limit_nm: 0.7\n").string()),
              HasSubstr("moment_limit_nm"));
}

}  // namespace
}  // namespace pickbed::tests
