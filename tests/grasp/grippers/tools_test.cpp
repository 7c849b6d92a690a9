#include "grasp/grippers/tools.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grasp/grippers/suction_cup.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Tools JawAndCup() { return LoadTools({"jaw_4cm", "cup_30mm"}); }

TEST(Tools, AreReadInTheirOrderAndFoundByName) {
  const Tools tools = JawAndCup();
  ASSERT_EQ(tools.size(), 2u);
  EXPECT_EQ(ToolNamed(tools, "cup_30mm").name, "cup_30mm");
  EXPECT_EQ(ToolNamed(tools, "").name, "jaw_4cm") << "records of earlier versions";
  EXPECT_THAT(ErrorOf([&] { ToolNamed(tools, "cup_31mm"); }), HasSubstr("cup_30mm"));
}

TEST(Tools, UnknownAndRepeatedNamesAreRefused) {
  EXPECT_THAT(ErrorOf([] { LoadTools({"jaw_4cm", "jaw_9cm"}); }), HasSubstr("jaw_9cm"));
  EXPECT_THAT(ErrorOf([] {
                LoadTools({"jaw_4cm", "jaw_4cm"});
              }),
              HasSubstr("two grippers are named jaw_4cm"));
}

// A cube of 6 cm is wider than the small jaw opens; a cup holds it.
TEST(Tools, ToolThatCannotHoldTheObjectIsNamed) {
  const ToolCandidates found =
      RequireToolCandidates(*BoxObject({0.06, 0.06, 0.06}, 0.2), JawAndCup());
  ASSERT_EQ(found.by_tool.size(), 2u);
  EXPECT_THAT(found.by_tool[0], IsEmpty());
  EXPECT_FALSE(found.by_tool[1].empty());
  EXPECT_THAT(found.unfit, ElementsAre("jaw_4cm"));
  EXPECT_EQ(UnfitToolsText({BoxObject({0.06, 0.06, 0.06}, 0.2)}, JawAndCup(), "a.yaml:3: gripper"),
            "a.yaml:3: gripper: jaw_4cm cannot hold 'box'; other grippers pick it\n");
  const ObjectSet two{BoxObject({0.06, 0.06, 0.06}, 0.2), BoxObject({0.05, 0.05, 0.05}, 0.2)};
  EXPECT_EQ(UnfitToolsText(two, JawAndCup(), "gripper"),
            "gripper: jaw_4cm cannot hold 'box', 'box'; other grippers pick them\n");
}

// The same cube is too heavy for the cup with 6 kg.
TEST(Tools, ObjectThatNoToolHoldsIsRefusedWithAllTools) {
  const auto heavy = BoxObject({0.06, 0.06, 0.06}, 6);
  const std::string error = ErrorOf([&] { RequireToolCandidates(*heavy, JawAndCup()); });
  EXPECT_THAT(error, HasSubstr("none of the grippers jaw_4cm, cup_30mm"));
  const std::string too_heavy = ErrorOf([&] { RequireSomeToolCarries(JawAndCup(), *heavy); });
  EXPECT_THAT(too_heavy, HasSubstr("too heavy"));
  EXPECT_THAT(too_heavy, HasSubstr("cup_30mm carries"));
}

}  // namespace
}  // namespace pickbed::tests
