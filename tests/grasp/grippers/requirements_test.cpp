#include "grasp/grippers/requirements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grasp/grippers/table.h"
#include "scenes/base/error.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

std::string FitErrorOf(const Gripper& gripper, const Eigen::Vector3d& inner_size_m) {
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
TEST(GripperRequirements, GripperWiderThanTheBinIsRefused) {
  const auto jaw = LoadGripper("jaw_8cm");
  EXPECT_EQ(FitErrorOf(*jaw, {0.40, 0.30, 0.15}), "");
  EXPECT_EQ(FitErrorOf(*jaw, {0.05, 0.11, 0.15}), "");  // rotated by 90 degrees
  EXPECT_THAT(FitErrorOf(*jaw, {0.09, 0.09, 0.15}), HasSubstr("'jaw_8cm' is wider than the bin"));
  EXPECT_EQ(FitErrorOf(*jaw, {0.09, 0.09, 0.04}), "");
  EXPECT_NE(FitErrorOf(*jaw, {0.015, 0.09, 0.04}), "");
  EXPECT_EQ(FitErrorOf(*jaw, {0.015, 0.09, 0}), "");  // a table
  EXPECT_NE(FitErrorOf(*LoadGripper("cup_30mm"), {0.02, 0.2, 0.05}), "");
}

TEST(GripperRequirements, AWidthBeyondTheOpeningIsRefused) {
  const auto jaw = LoadGripper("jaw_8cm");
  EXPECT_NO_THROW(RequireOpensFor(*jaw, 0.08));
  try {
    RequireOpensFor(*jaw, 0.081);
    FAIL() << "threw no InputError";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "width_m = 0.081: gripper jaw_8cm opens at most 0.08 m");
  }
  EXPECT_NO_THROW(RequireOpensFor(*LoadGripper("cup_30mm"), 1)) << "a cup has no fingers";
}

TEST(GripperRequirements, TooHeavyObjectsAreRefused) {
  ObjectModel object;
  object.name = "anvil";
  object.friction = 0.5;
  const auto jaw = LoadGripper("jaw_8cm");  // 2 * 0.5 * 40 N
  object.mass.mass_kg = 4.0;
  EXPECT_NO_THROW(RequireCanCarry(*jaw, object));
  object.mass.mass_kg = 4.1;
  try {
    RequireCanCarry(*jaw, object);
    FAIL() << "threw no InputError";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("object 'anvil' is too heavy for gripper 'jaw_8cm'"));
    EXPECT_THAT(error.what(), HasSubstr("40 N"));
  }
  EXPECT_NO_THROW(RequireCanCarry(*LoadGripper("cup_30mm"), object));
  object.mass.mass_kg = 4.6;
  EXPECT_THROW(RequireCanCarry(*LoadGripper("cup_30mm"), object), InputError);
}

}  // namespace
}  // namespace pickbed::tests
