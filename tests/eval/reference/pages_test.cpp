#include "eval/reference/pages.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <regex>

#include "eval/benchmark/crops.h"
#include "eval/cli/commands.h"
#include "eval/grasps/physics_trials.h"
#include "eval/reference/markdown.h"
#include "eval/reference/setting_rows.h"
#include "eval/sweep/sweep_spec.h"
#include "eval/tolerance/samples.h"
#include "grasp/candidates/candidates.h"
#include "grasp/grippers/table.h"
#include "perception/completion/completion_training.h"
#include "perception/training/training.h"
#include "perception/training/verifier_training.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/find_scenario.h"
#include "sim/sensor/sensor_profile.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr int kMaxLines = 300;

const Pages& AllPages() {
  static const Pages pages = ReferencePages();
  return pages;
}

// Replaces the index of each list item by N.
std::string WithoutIndices(const std::string& key) {
  static const std::regex index("\\.[0-9]+(?=\\.|$)");
  return std::regex_replace(key, index, ".N");
}

void ExpectRow(const std::string& page, const std::string& name) {
  EXPECT_THAT(AllPages().at(page), HasSubstr(fmt::format("| `{}` |", name))) << page;
}

// Expects each key of the written settings on the page; groups and lists may be headings.
void ExpectKeys(const std::string& page, const VisitFunction& visit) {
  for (const auto& [key, place] : ReadSettingsText(WriteSettings(visit), "settings", visit)) {
    const std::string name = WithoutIndices(key);
    if (name.ends_with(".N")) continue;
    if (AllPages().at(page).find("\n### " + name + "\n") != std::string::npos) continue;
    ExpectRow(page, name);
  }
}

template <typename Settings>
void ExpectKeysOf(const std::string& page, Settings settings) {
  ExpectKeys(page, [&](SettingsVisitor& v) { settings.Visit(v); });
}

TEST(ReferencePages, EveryPageHasATitleAndLimitedLength) {
  EXPECT_GE(AllPages().size(), 3u);
  for (const auto& [name, text] : AllPages()) {
    EXPECT_EQ(text.substr(0, 2), "# ") << name;
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), kMaxLines) << name;
    EXPECT_THAT(text, HasSubstr(kGeneratedMark)) << name;
  }
}

TEST(ReferencePages, LinksLeadToGeneratedPages) {
  static const std::regex link("\\]\\(([a-z_]+\\.md)(#([a-z0-9-]+))?\\)");
  int links = 0;
  for (const auto& [name, text] : AllPages()) {
    for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match) {
      ++links;
      const auto page = AllPages().find((*match)[1]);
      ASSERT_NE(page, AllPages().end()) << name << ": " << (*match)[0];
      std::string heading = (*match)[3];
      std::replace(heading.begin(), heading.end(), '-', ' ');
      std::string headings = page->second;
      std::transform(headings.begin(), headings.end(), headings.begin(),
                     [](unsigned char c) { return std::tolower(c); });
      EXPECT_THAT(headings, HasSubstr("# " + heading)) << name << ": " << (*match)[0];
    }
  }
  EXPECT_GT(links, 20);
}

TEST(ReferencePages, HaveEveryKeyOfScenariosAndOfTheFilesTheyName) {
  for (const std::string& preset : PresetNames()) {
    ExpectKeysOf("settings.md", LoadScenario(PresetsDir() / (preset + ".yaml")));
  }
  ExpectKeysOf("settings_files.md", BinSpec());
  ExpectKeysOf("settings_files.md", SensorProfile());
  for (const std::string& name : GripperNames()) {
    const std::string text = LoadGripper(name)->SettingsText();
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      ExpectRow("settings_files.md", line.substr(0, line.find(':')));
    }
  }
  for (const SweepKey& key : SweepKeys()) {
    if (std::string(key.name) != "slurm") ExpectRow("settings_files.md", key.name);
  }
  for (const char* key : {"slurm.shards", "slurm.options"}) ExpectRow("settings_files.md", key);
}

TEST(ReferencePages, HaveEveryKeyOfTheShippedObjects) {
  static const std::regex key("^ *(?:- )?\\{?([a-z_0-9]+):");
  int keys = 0;
  for (const std::string& name : ObjectCatalog({AssetsDir() / "objects"}).Names()) {
    std::istringstream lines(ReadFileBytes(AssetsDir() / "objects" / name / "object.yaml"));
    for (std::string line; std::getline(lines, line);) {
      std::smatch match;
      if (!std::regex_search(line, match, key)) continue;
      ++keys;
      const std::string text = AllPages().at("settings_files.md");
      const std::string found = match[1];
      EXPECT_TRUE(text.find(fmt::format("{}` |", found)) != std::string::npos ||
                  text.find("\n### " + found + "\n") != std::string::npos)
          << found << " of " << name;
    }
  }
  EXPECT_GT(keys, 20);
}

TEST(ReferencePages, HaveEveryKeyOfTrainingAndMeasurements) {
  ExpectKeysOf("settings_training.md", TrainingOptions());
  ExpectKeysOf("settings_training.md", VerifierTrainingOptions());
  ExpectRow("settings_training.md", "wohlhart.network.anchors");
  ExpectKeysOf("settings_completion.md", CompletionTrainingOptions());
  ExpectKeysOf("settings_measurements.md", CropBenchmarkOptions());
  ExpectKeysOf("settings_measurements.md", ToleranceOptions());
  ExpectKeysOf("settings_grasps.md", GraspCandidateOptions());
  ExpectKeysOf("settings_grasps.md", GraspTestOptions());
}

TEST(ReferencePages, HaveEveryCommandAndOptionOfTheHelp) {
  std::string text;
  for (const auto& [name, page] : AllPages()) {
    if (name.starts_with("commands")) text += page;
  }
  static const std::regex option("\\n *(--[a-z-]+)");
  int options = 0;
  const auto expect = [&](const CommandRow& row, std::vector<std::string> words) {
    words.insert(words.begin(), row.name);
    words.emplace_back("--help");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    testing::internal::CaptureStdout();
    row.run(static_cast<int>(argv.size()), argv.data());
    fflush(stdout);
    const std::string help = testing::internal::GetCapturedStdout();
    for (std::sregex_iterator match(help.begin(), help.end(), option), end; match != end; ++match) {
      ++options;
      EXPECT_THAT(text, HasSubstr("`" + std::string((*match)[1]))) << row.name;
    }
  };
  for (const CommandRow& row : CommandTable()) {
    EXPECT_THAT(text, HasSubstr(fmt::format("\n## pickbed {}\n", row.name)));
    expect(row, {});
    if (row.subcommands == nullptr) continue;
    for (const CommandRow& subcommand : row.subcommands()) expect(subcommand, {});
  }
  EXPECT_GT(options, 100);
}

TEST(ReferencePages, DoNotNameThisMachine) {
  for (const auto& [name, text] : AllPages()) {
    EXPECT_THAT(text, Not(HasSubstr(std::filesystem::current_path().string()))) << name;
    EXPECT_THAT(text, Not(HasSubstr(AssetsDir().string()))) << name;
  }
}

TEST(WriteReference, RemovesOldGeneratedPagesOnly) {
  const TemporaryFolder folder;
  folder.Write("old.md", PageHead("Old"));
  folder.Write("own.md", "# Own\n");
  WriteReference(folder.path());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "old.md"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "own.md"));
  for (const auto& [name, text] : AllPages()) EXPECT_EQ(ReadFileBytes(folder.path() / name), text);
}

TEST(SettingRows, HaveRangeDefaultUnitAndHelp) {
  double length_m = 0.25;
  std::string mode = "fast";
  std::vector<int> counts;
  const std::vector<SettingRow> rows = SettingRows([&](SettingsVisitor& v) {
    v.Real("length_m", length_m, {0, 1}, "length, m");
    v.Group(
        "search",
        [&](SettingsVisitor& g) {
          g.Text("mode", mode, {"fast", "accurate"}, "mode");
        },
        "search");
    v.List(
        "items", counts.size(), [&](size_t size) { counts.resize(size, 7); },
        [&](size_t i, SettingsVisitor& item) {
          item.Integer("count", counts[i], {1, 9}, "count");
        },
        "items");
  });
  std::vector<std::string> texts;
  for (const SettingRow& row : rows) {
    texts.push_back(row.key + "; " + row.value + "; " + row.default_value + "; " + row.unit + "; " +
                    row.help);
  }
  EXPECT_THAT(
      texts,
      ElementsAre("length_m; number from 0 to 1; 0.25; m; length, m", "search; group; ; ; search",
                  "search.mode; fast, accurate; fast; ; mode", "items; list; empty; ; items",
                  "items.N.count; whole number from 1 to 9; 7; ; count"));
}

TEST(Markdown, SpecialCharactersAreEscapedExceptInCode) {
  EXPECT_EQ(MarkdownText("a|b <c> [d] e_f `g_h`"), "a\\|b &lt;c> \\[d\\] e\\_f `g_h`");
  EXPECT_EQ(MarkdownCode("a|b_c"), "`a\\|b_c`");
  EXPECT_EQ(MarkdownTable({{"a", "b"}, {"1", "2"}}), "| a | b |\n|---|---|\n| 1 | 2 |\n");
}

}  // namespace
}  // namespace pickbed::tests
