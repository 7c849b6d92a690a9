#include "scenes/base/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "tests/support/error_of.h"
#include "tests/support/layer.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

struct Item {
  int count = 1;
  void Visit(SettingsVisitor& v) { v.Integer("count", count, {1, 10}, "how many"); }
};

struct Sample {
  uint64_t seed = 7;
  double wall_m = 0.006;
  bool deep = false;
  std::string mode = "fast";
  std::vector<std::string> tools{"jaw"};
  std::vector<std::string> command;
  Eigen::Vector3d size_m{1, 2, 3};
  std::vector<Item> items;
  void Visit(SettingsVisitor& v) {
    v.Seed("seed", seed, "seed");
    v.Group(
        "bin",
        [this](SettingsVisitor& g) {
          g.Real("wall_m", wall_m, {0.001, 0.05}, "wall, m");
        },
        "bin");
    v.Bool("deep", deep, "deep");
    v.Text("mode", mode, {"fast", "hard"}, "mode");
    v.Names("tools", tools, "tools");
    v.Words("command", command, "program");
    v.Vector3("size_m", size_m, {0, 10}, "size, m");
    v.List(
        "items", items.size(), [this](size_t n) { items.assign(n, {}); },
        [this](size_t i, SettingsVisitor& item) { items[i].Visit(item); }, "items");
  }
};

VisitFunction Visiting(Sample& sample) {
  return [&sample](SettingsVisitor& v) { sample.Visit(v); };
}

std::string ErrorOfYaml(const std::string& yaml) {
  Sample sample;
  try {
    ReadSettingsText(yaml, "cell.yaml", Visiting(sample));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Settings, ReadsEveryKindOfField) {
  Sample sample;
  ReadSettingsText(
      "seed: 18446744073709551615\nbin: {wall_m: 0.02}\ndeep: true\nmode: hard\n"
      "size_m: [4, 5, 6]\nitems:\n  - {count: 3}\n  - {}\n",
      "cell.yaml", Visiting(sample));
  EXPECT_EQ(sample.seed, UINT64_MAX);
  EXPECT_EQ(sample.wall_m, 0.02);
  EXPECT_TRUE(sample.deep);
  EXPECT_EQ(sample.mode, "hard");
  EXPECT_EQ(sample.size_m, Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(sample.items.size(), 2u);
  EXPECT_EQ(sample.items[0].count, 3);
  EXPECT_EQ(sample.items[1].count, 1);
}

TEST(Settings, WordsAreAListOrATextWithSpaces) {
  Sample sample;
  EXPECT_THAT(WriteSettings(Visiting(sample)), HasSubstr("command: []\n"));
  ReadSettingsText("command: [python3, \"my file.py\"]", "cell.yaml", Visiting(sample));
  EXPECT_EQ(sample.command, (std::vector<std::string>{"python3", "my file.py"}));
  Sample again;
  ReadSettingsText(WriteSettings(Visiting(sample)), "cell.yaml", Visiting(again));
  EXPECT_EQ(again.command, sample.command);
  ApplySetting("command=python3  b.py", Visiting(sample));
  EXPECT_EQ(sample.command, (std::vector<std::string>{"python3", "b.py"}));
  ApplySetting("command=[]", Visiting(sample));
  EXPECT_TRUE(sample.command.empty());
  EXPECT_THAT(ErrorOfYaml("command: {a: b}"), HasSubstr("must be a list of words (program)"));
  EXPECT_THAT(ErrorOfYaml("command: [a, [b]]"), HasSubstr("must be a list of words (program)"));
}

TEST(Settings, NamesAreOneNameOrAList) {
  Sample sample;
  ReadSettingsText("tools: [jaw, \"small cup\"]", "cell.yaml", Visiting(sample));
  EXPECT_EQ(sample.tools, (std::vector<std::string>{"jaw", "small cup"}));
  Sample again;
  ReadSettingsText(WriteSettings(Visiting(sample)), "cell.yaml", Visiting(again));
  EXPECT_EQ(again.tools, sample.tools);
  ApplySetting("tools=cup", Visiting(sample));
  EXPECT_EQ(sample.tools, std::vector<std::string>{"cup"});
  EXPECT_THAT(WriteSettings(Visiting(sample)), HasSubstr("tools: \"cup\"\n"))
      << "one name is written as before there were lists";
  EXPECT_THAT(ErrorOfYaml("tools: []"), HasSubstr("cell.yaml:1: tools = []: must be a name or"));
  EXPECT_THAT(ErrorOfYaml("tools: [jaw, [cup]]"), HasSubstr("must be a name or a list of names"));
  sample.tools.clear();
  EXPECT_THAT(SettingFaults(Visiting(sample)), testing::SizeIs(1));
}

TEST(Settings, MissingKeysKeepTheirValues) {
  Sample sample;
  ReadSettingsText("", "cell.yaml", Visiting(sample));
  EXPECT_EQ(sample.seed, 7u);
  EXPECT_EQ(sample.mode, "fast");
}

TEST(Settings, AFileWithoutSettingsIsRefused) {
  const TemporaryFolder folder;
  for (const char* yaml : {"", "\n", "# A jaw with l", "{}", "---\n"}) {
    const std::string file = folder.Write("a.yaml", yaml);
    Sample sample;
    EXPECT_THAT(ErrorOf([&] { ReadSettingsFile(file, Visiting(sample)); }),
                HasSubstr(file + ": the file has no settings"))
        << yaml;
  }
}

TEST(Settings, WrittenSettingsReadBackUnchanged) {
  Sample sample;
  sample.seed = 0;
  sample.wall_m = 0.1 / 3 / 10;
  sample.mode = "hard";
  sample.size_m = {0.1, 1e-9, 9.999};
  sample.items = {{4}, {5}};
  for (const bool with_help : {false, true}) {
    const std::string text = WriteSettings(Visiting(sample), with_help);
    Sample copy;
    ReadSettingsText(text, "copy", Visiting(copy));
    EXPECT_EQ(WriteSettings(Visiting(copy), with_help), text);
    EXPECT_EQ(copy.wall_m, sample.wall_m);
    EXPECT_EQ(copy.size_m, sample.size_m);
    ASSERT_EQ(copy.items.size(), 2u);
    EXPECT_EQ(copy.items[1].count, 5);
  }
}

TEST(Settings, ErrorsHoldFileLineKeyValueAndAllowedValues) {
  const struct {
    const char* yaml;
    std::vector<const char*> fragments;
  } cases[] = {
      {"seed: 1\nbin:\n  wall_m: 3\n", {"cell.yaml:3:", "bin.wall_m = 3", "from 0.001 to 0.05"}},
      {"seed: 1\nbin:\n  wal_m: 0.01\n", {"cell.yaml:3:", "wal_m", "wall_m", "0.01"}},
      {"mode: medium\n", {"cell.yaml:1:", "mode", "medium", "fast", "hard"}},
      {"deep: 3.5\n", {"cell.yaml:1:", "deep = 3.5", "true or false"}},
      {"seed: -1\n", {"cell.yaml:1:", "seed = -1", "whole number from 0"}},
      {"seed: 99999999999999999999\n", {"cell.yaml:1:", "seed", "whole number"}},
      {"items:\n - {count: 2.5}\n", {"cell.yaml:2:", "items.0.count = 2.5", "whole number"}},
      {"items:\n - {count: 0}\n", {"cell.yaml:2:", "items.0.count = 0", "from 1 to 10"}},
      {"items: 4\n", {"cell.yaml:1:", "items = 4", "list"}},
      {"size_m: [1, 2]\n", {"cell.yaml:1:", "size_m = [1, 2]", "3 numbers"}},
      {"size_m: [1, 2, .nan]\n", {"cell.yaml:1:", "size_m", "from 0 to 10"}},
      {"bin: [1]\n", {"cell.yaml:1:", "bin", "key: value"}},
      {"deep: true\ndeep: false\n",
       {"cell.yaml:2: deep = false: is given twice, before as true at cell.yaml:1"}},
      {"\"de\\np\": 1\n", {"cell.yaml:1: unknown key 'de\\x0ap'"}},
      {"mode: \"fa\\nst\"\n", {"cell.yaml:1: unknown mode 'fa\\x0ast'"}},
      {"seed: [\n", {"cell.yaml:", "not valid YAML"}},
  };
  for (const auto& c : cases) {
    const std::string error = ErrorOfYaml(c.yaml);
    for (const char* fragment : c.fragments) EXPECT_THAT(error, HasSubstr(fragment)) << c.yaml;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(Settings, AssignmentsReachGroupsAndListItems) {
  Sample sample;
  sample.items = {{1}, {2}};
  ApplySetting("bin.wall_m=0.01", Visiting(sample));
  ApplySetting("items.1.count=9", Visiting(sample));
  ApplySetting("size_m=[7, 8, 9]", Visiting(sample));
  EXPECT_EQ(sample.wall_m, 0.01);
  EXPECT_EQ(sample.items[0].count, 1);
  EXPECT_EQ(sample.items[1].count, 9);
  EXPECT_EQ(sample.size_m, Eigen::Vector3d(7, 8, 9));
  EXPECT_THAT(ErrorOf([&] { ApplySetting("items.1.={count: 3}", Visiting(sample)); }),
              HasSubstr("ends with a dot"));
  EXPECT_EQ(sample.items[1].count, 9);
}

TEST(Settings, InvalidAssignmentsAreRefused) {
  Sample sample;
  sample.items = {{1}};
  for (const char* assignment : {"bin.wal_m=0.01", "bin.wall_m=9", "items.3.count=1",
                                 "items.x.count=1", "seed", "=3", "bin=3"}) {
    EXPECT_THROW(ApplySetting(assignment, Visiting(sample)), InputError) << assignment;
  }
}

TEST(Settings, MissingFileErrorHoldsThePath) {
  Sample sample;
  try {
    ReadSettingsFile("/nowhere/cell.yaml", Visiting(sample));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/cell.yaml"));
  }
}

}  // namespace
}  // namespace pickbed::tests
