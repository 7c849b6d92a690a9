#include "scenes/base/settings_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr char kText[] =
    "name: a\n"
    "list: [1, two, {x: 3}]\n"
    "map:\n"
    "  deep: {key: [1, 2]}\n";

TEST(SettingsTree, KeepsKindsTextsAndLineNumbers) {
  const SettingsTree tree = ReadSettingsTreeText(kText, "f.yaml");
  ASSERT_EQ(tree.items.size(), 3u);
  EXPECT_EQ(tree.Find("name")->text, "a");
  EXPECT_EQ(tree.Find("name")->place, "f.yaml:1");
  const SettingsTree& list = *tree.Find("list");
  EXPECT_EQ(list.kind, SettingsTree::Kind::kList);
  ASSERT_EQ(list.items.size(), 3u);
  EXPECT_EQ(list.items[1].text, "two");
  EXPECT_EQ(list.items[2].kind, SettingsTree::Kind::kMap);
  EXPECT_EQ(tree.Find("map")->Find("deep")->text, "{key: [1, 2]}");
  EXPECT_EQ(tree.Find("map")->Find("deep")->place, "f.yaml:4");
  EXPECT_EQ(tree.Find("nothing"), nullptr);
}

TEST(SettingsTree, TextsAreOneLineForAnyYamlStyle) {
  const SettingsTree tree = ReadSettingsTreeText(
      "grid:\n  sensor: [a, b]\n  pair:\n    - x: 1\n      y: 2\n    - {x: 3}\n", "f.yaml");
  EXPECT_EQ(tree.Find("grid")->text, "{sensor: [a, b], pair: [{x: 1, y: 2}, {x: 3}]}");
}

TEST(SettingsTree, KeysWithControlCharactersAreRefusedInOneLine) {
  const std::string error = ErrorOf([] { ReadSettingsTreeText("a: 1\n\"b\\nc\": 2\n", "f.yaml"); });
  EXPECT_EQ(error, "f.yaml:2: the key 'b\\x0ac' has a control character");
}

TEST(SettingsTree, BlockIsReadIntoTheVisitedFields) {
  double wall_m = 0;
  int count = 0;
  const auto visit = [&](SettingsVisitor& v) {
    v.Real("wall_m", wall_m, {0, 1}, "wall");
    v.Group(
        "group",
        [&](SettingsVisitor& g) {
          g.Integer("count", count, {1, 9}, "how many");
        },
        "");
  };
  const auto read = [&](const std::string& yaml) {
    ReadSettingsBlock(*ReadSettingsTreeText(yaml, "f.yaml").Find("block"), visit);
  };
  read("block:\n  wall_m: 0.25\n  group: {count: 4}\n");
  EXPECT_EQ(wall_m, 0.25);
  EXPECT_EQ(count, 4);
  const std::string error = ErrorOf([&] { read("block:\n  wall_m: 0.5\n  group: {count: 12}\n"); });
  EXPECT_THAT(error, HasSubstr("f.yaml:3"));
  EXPECT_THAT(error, HasSubstr("group.count = 12"));
  EXPECT_THAT(ErrorOf([&] { read("block:\n  wal_m: 0.5\n"); }),
              AllOf(HasSubstr("f.yaml:2"), HasSubstr("did you mean 'wall_m'")));
  EXPECT_THAT(ErrorOf([&] { read("block: 3\n"); }), HasSubstr("'key: value'"));
}

}  // namespace
}  // namespace pickbed::tests
