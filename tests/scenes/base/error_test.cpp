#include "scenes/base/error.h"

#include <gmock/gmock.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(CheckInput, ThrowsTheMessageIfFalse) {
  EXPECT_NO_THROW(CheckInput(true, "never"));
  try {
    CheckInput(false, "bin.yaml:3: wall_m = -1: must be positive");
    FAIL() << "threw no InputError";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "bin.yaml:3: wall_m = -1: must be positive");
  }
}

TEST(NearestName, FindsTheNameOfATypingError) {
  const std::vector<std::string> known = {"bracket", "pipe_tee", "rod", "hex_bolt"};
  struct {
    const char* typed;
    const char* nearest;
  } cases[] = {
      {"bracket", "bracket"},
      {"brcket", "bracket"},
      {"brakcet", "bracket"},
      {"pipe-tee", "pipe_tee"},
      {"hexbolt", "hex_bolt"},
      {"rd", "rod"},
      {"spoon", ""},
      {"", ""},
      {"xyz", ""},
  };
  for (const auto& c : cases) EXPECT_EQ(NearestName(c.typed, known), c.nearest) << c.typed;
}

TEST(NearestName, PrefersTheNearestThenTheFirst) {
  EXPECT_EQ(NearestName("gearx", {"gear_big", "gears", "gear"}), "gears");
  EXPECT_EQ(NearestName("gear", {}), "");
}

TEST(UnknownNameMessage, HoldsNameSuggestionAndKnownNamesInOneLine) {
  const std::string message = UnknownNameMessage("gripper", "jwa", {"jaw", "cup"});
  EXPECT_EQ(message, "unknown gripper 'jwa'; did you mean 'jaw'? known: jaw, cup");
  EXPECT_EQ(UnknownNameMessage("object", "spoon", {"rod"}), "unknown object 'spoon'; known: rod");
  EXPECT_THAT(UnknownNameMessage("object", "spoon", {}), HasSubstr("none is known"));
}

}  // namespace
}  // namespace pickbed::tests
