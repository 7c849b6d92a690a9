#include "grasp/gripper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "scenes/check.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

using testing::HasSubstr;

// The file is there until the next call.
std::filesystem::path YamlWith(const std::string& text) {
  static std::unique_ptr<TemporaryFolder> folder;
  folder = std::make_unique<TemporaryFolder>();
  return folder->Write("gripper.yaml", text);
}

std::string ErrorOf(const std::string& name_or_path) {
  try {
    LoadGripper(name_or_path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Gripper, EveryShippedOneLoadsAndTakesAPart) {
  ASSERT_FALSE(GripperNames().empty());
  for (const std::string& name : GripperNames()) {
    const GripperSpec gripper = LoadGripper(name);
    EXPECT_EQ(gripper.name, name);
    EXPECT_TRUE(MechanismOf(gripper).approach_opening_m(gripper, 0.02)) << name;
  }
}

TEST(Gripper, FileOverridesDefaultsAndKeepsTheRest) {
  const GripperSpec gripper = LoadGripper(YamlWith("stroke_m: 0.06\nforce_n: 12.5\n").string());
  EXPECT_EQ(gripper.name, "gripper");
  EXPECT_EQ(gripper.hand.stroke_m, 0.06);
  EXPECT_EQ(gripper.hand.force_n, 12.5);
  EXPECT_EQ(gripper.hand.finger_mass_kg, HandSpec{}.finger_mass_kg);
}

TEST(Gripper, UnknownNameGivesTheNearest) {
  EXPECT_THAT(ErrorOf("jaw_8cn"), HasSubstr("did you mean 'jaw_8cm'"));
}

TEST(Gripper, UnknownMechanismIsNamed) {
  EXPECT_THAT(ErrorOf(YamlWith("mechanism: parallel_jaws\n").string()),
              HasSubstr("did you mean 'parallel_jaw'"));
}

TEST(Gripper, ForceMustBePositive) {
  const auto file = YamlWith("stroke_m: 0.08\nforce_n: 0\n");
  EXPECT_THAT(ErrorOf(file.string()), HasSubstr(file.string() + ":2: force_n = 0"));
}

TEST(Gripper, SizesMustBePositive) {
  EXPECT_THAT(ErrorOf(YamlWith("finger_size_m: [0.01, -0.02, 0.05]\n").string()),
              HasSubstr("finger_size_m"));
}

TEST(Gripper, PalmMustCarryTheOpenFingers) {
  EXPECT_THAT(ErrorOf(YamlWith("stroke_m: 0.14\n").string()), HasSubstr("palm_size_m"));
}

TEST(Gripper, ClearanceMustLeaveStroke) {
  EXPECT_THAT(ErrorOf(YamlWith("stroke_m: 0.02\nclearance_m: 0.01\n").string()),
              HasSubstr("clearance_m"));
}

TEST(Gripper, ApproachOpeningIsWidthAndClearanceWithinTheStroke) {
  GripperSpec gripper;
  gripper.hand.stroke_m = 0.08;
  gripper.clearance_m = 0.003;
  const auto opening = MechanismOf(gripper).approach_opening_m;
  EXPECT_DOUBLE_EQ(opening(gripper, 0.05).value(), 0.056);
  EXPECT_TRUE(opening(gripper, 0.0739));
  EXPECT_FALSE(opening(gripper, 0.0741));
}

TEST(Gripper, CupIsReadByItsOwnKeys) {
  const GripperSpec cup = LoadGripper("cup_30mm");
  EXPECT_EQ(cup.mechanism, "suction_cup");
  EXPECT_EQ(cup.cup.radius_m, 0.015);
  EXPECT_THAT(ErrorOf(YamlWith("mechanism: suction_cup\nstroke_m: 0.08\n").string()),
              HasSubstr("stroke_m"));
  EXPECT_THAT(ErrorOf(YamlWith("vacuum_n: 45\n").string()), HasSubstr("vacuum_n"));
}

TEST(Gripper, CupsWithImpossibleNumbersAreRefused) {
  const std::string cup = "mechanism: suction_cup\n";
  EXPECT_THAT(ErrorOf(YamlWith(cup + "vacuum_n: 0\n").string()), HasSubstr(":2: vacuum_n = 0"));
  EXPECT_THAT(ErrorOf(YamlWith(cup + "radius_m: -0.01\n").string()), HasSubstr("radius_m = -0.01"));
  EXPECT_THAT(ErrorOf(YamlWith(cup + "press_m: 0.009\n").string()), HasSubstr("bellows_travel_m"));
  // The air's pressure on a lip of 15 mm is 71.6 N.
  EXPECT_THAT(ErrorOf(YamlWith(cup + "vacuum_n: 73\n").string()), HasSubstr("71.6 N"));
  EXPECT_THAT(ErrorOf(YamlWith(cup + "moment_limit_nm: 0.7\n").string()),
              HasSubstr("moment_limit_nm"));
}

std::string FitErrorOf(const GripperSpec& gripper, const Eigen::Vector3d& inner_size_m) {
  Bin bin;
  bin.inner_size_m = inner_size_m;
  try {
    RequireFitsBin(gripper, bin);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// The fingers of jaw_8cm are 5 cm long: deeper in, its palm of 10 x 4 cm comes along.
TEST(Gripper, WiderThanTheBinIsRefused) {
  const GripperSpec jaw = LoadGripper("jaw_8cm");
  EXPECT_EQ(FitErrorOf(jaw, {0.40, 0.30, 0.15}), "");
  EXPECT_EQ(FitErrorOf(jaw, {0.05, 0.11, 0.15}), "");  // turned
  EXPECT_THAT(FitErrorOf(jaw, {0.09, 0.09, 0.15}), HasSubstr("'jaw_8cm' is wider than the bin"));
  EXPECT_EQ(FitErrorOf(jaw, {0.09, 0.09, 0.04}), "");
  EXPECT_NE(FitErrorOf(jaw, {0.015, 0.09, 0.04}), "");
  EXPECT_EQ(FitErrorOf(jaw, {0.015, 0.09, 0}), "");  // a table
  EXPECT_NE(FitErrorOf(LoadGripper("cup_30mm"), {0.02, 0.2, 0.05}), "");
}

TEST(Gripper, PartsTooHeavyAreRefused) {
  ObjectModel part;
  part.name = "anvil";
  part.friction = 0.5;
  const GripperSpec jaw = LoadGripper("jaw_8cm");  // 2 * 0.5 * 40 N
  part.mass.mass_kg = 4.0;
  EXPECT_NO_THROW(RequireCanCarry(jaw, part));
  part.mass.mass_kg = 4.1;
  try {
    RequireCanCarry(jaw, part);
    FAIL() << "carried";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("part 'anvil' is too heavy for gripper 'jaw_8cm'"));
    EXPECT_THAT(error.what(), HasSubstr("40 N"));
  }
  EXPECT_NO_THROW(RequireCanCarry(LoadGripper("cup_30mm"), part));
  part.mass.mass_kg = 4.6;
  EXPECT_THROW(RequireCanCarry(LoadGripper("cup_30mm"), part), InputError);
}

}  // namespace
}  // namespace pickbed
