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

}  // namespace
}  // namespace pickbed
