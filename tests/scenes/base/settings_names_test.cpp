#include "scenes/base/settings_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

// Settings with names of an earlier version are read as with the names of now, and reported in one
// line per file.

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

struct RenamedItem {
  int count = 1;
  bool distractor = false;
  void Visit(SettingsVisitor& v) {
    v.Integer("count", count, {1, 10}, "how many");
    v.RenamedKey("foreign", "distractor");
    v.Bool("distractor", distractor, "not wanted");
  }
};

struct Search {
  std::string mode = "fast";
  double min_share = 0;
  void Visit(SettingsVisitor& v) {
    v.RenamedValue("mode", "hard", "accurate");
    v.Text("mode", mode, {"fast", "accurate"}, "search mode");
    v.RenamedKey("least_share", "min_share");
    v.Real("min_share", min_share, {0, 1}, "share");
  }
};

struct RenamedSample {
  int samples = 0;
  Search search;
  std::vector<RenamedItem> items;
  void Visit(SettingsVisitor& v) {
    v.RenamedKey("tries", "samples");
    v.Integer("samples", samples, {0, 100}, "samples");
    v.RenamedKey("look", "search");
    v.Group(
        "search", [this](SettingsVisitor& g) { search.Visit(g); }, "search");
    v.List(
        "items", items.size(), [this](size_t n) { items.assign(n, {}); },
        [this](size_t i, SettingsVisitor& item) { items[i].Visit(item); }, "items");
  }
};

VisitFunction VisitRenamed(RenamedSample& sample) {
  return [&sample](SettingsVisitor& v) { sample.Visit(v); };
}

std::string Effective(const RenamedSample& sample) {
  RenamedSample copy = sample;
  return WriteSettings(VisitRenamed(copy));
}

constexpr const char* kFormer =
    "# a file of an earlier version: tries, hard\n"
    "tries: 7\n"
    "look:\n"
    "  mode: \"hard\"  # thorough\n"
    "  least_share: 0.25\n"
    "items:\n"
    "  - {count: 2, foreign: true}\n"
    "  - count: 3\n"
    "    'foreign': false\n";

constexpr const char* kCurrent =
    "# a file of an earlier version: tries, hard\n"
    "samples: 7\n"
    "search:\n"
    "  mode: \"accurate\"  # thorough\n"
    "  min_share: 0.25\n"
    "items:\n"
    "  - {count: 2, distractor: true}\n"
    "  - count: 3\n"
    "    'distractor': false\n";

class SettingsNames : public testing::Test {
 protected:
  SettingsNames() {
    before_ = SetDeprecationListener([this](const std::string& line) { lines_.push_back(line); });
  }
  ~SettingsNames() override { SetDeprecationListener(before_); }

  std::vector<std::string> lines_;  // reported
  RenamedSample sample_;
  const TemporaryFolder temporary_;

 private:
  DeprecationListener before_;
};

TEST_F(SettingsNames, OnlyTheFormerNamesOfATextAreReplaced) {
  EXPECT_EQ(WithCurrentNames(kFormer, VisitRenamed(sample_)).text, kCurrent);
  EXPECT_EQ(WithCurrentNames(kCurrent, VisitRenamed(sample_)).text, kCurrent);
  EXPECT_EQ(Effective(sample_), Effective(RenamedSample()))
      << "the target of the visit was changed";
}

TEST_F(SettingsNames, NamesBelongToTheirMap) {
  // `foreign` is a key of an item, `tries` of the outermost map, `hard` a value of `mode`.
  const std::pair<const char*, const char*> kTexts[] = {
      {"foreign: true\n", "foreign: true\n"},
      {"look: {foreign: 1}\n", "search: {foreign: 1}\n"},
      {"items: [{tries: 1}]\n", "items: [{tries: 1}]\n"},
      {"search: {least_share: hard}\n", "search: {min_share: hard}\n"},
  };
  for (const auto& [former, current] : kTexts) {
    EXPECT_EQ(WithCurrentNames(former, VisitRenamed(sample_)).text, current);
  }
}

TEST_F(SettingsNames, FormerFileGivesTheSameSettingsAndOneLine) {
  RenamedSample current;
  ReadSettingsFile(temporary_.Write("current.yaml", kCurrent), VisitRenamed(current));
  EXPECT_THAT(lines_, IsEmpty());
  const auto file = temporary_.Write("former.yaml", kFormer);
  const KeyPlaces places = ReadSettingsFile(file, VisitRenamed(sample_));
  EXPECT_EQ(Effective(sample_), Effective(current));
  EXPECT_EQ(sample_.search.mode, "accurate");
  EXPECT_EQ(places.at("search.min_share"), file.string() + ":5");
  EXPECT_THAT(lines_,
              ElementsAre(file.string() +
                          ":2: 'tries' is deprecated, write 'samples'; line 3: 'look' is "
                          "deprecated, write 'search'; line 4: 'mode: hard' is deprecated, write "
                          "'mode: accurate'; line 5: 'least_share' is deprecated, write "
                          "'min_share'; line 7: 'foreign' is deprecated, write 'distractor'"));
}

TEST_F(SettingsNames, StoredTextIsReadWithoutAReport) {
  ReadSettingsText(kFormer, "settings of a store", VisitRenamed(sample_));
  EXPECT_EQ(sample_.samples, 7);
  EXPECT_TRUE(sample_.items.at(0).distractor);
  EXPECT_THAT(lines_, IsEmpty());
}

TEST_F(SettingsNames, FormerAndCurrentNameTogetherAreRefused) {
  EXPECT_THAT(ErrorOf([&] {
                ReadSettingsText("tries: 1\nsamples: 2\n", "cell.yaml", VisitRenamed(sample_));
              }),
              HasSubstr("cell.yaml:2: samples = 2: is given twice, before as 1 at cell.yaml:1"));
}

TEST_F(SettingsNames, ErrorsOfAFormerFileNameItsLineAndTheCurrentKey) {
  const auto file =
      temporary_.Write("wrong.yaml", "items:\n  - count: 1\nlook: {least_share: 2}\n");
  EXPECT_THAT(ErrorOf([&] { ReadSettingsFile(file, VisitRenamed(sample_)); }),
              HasSubstr("wrong.yaml:3: search.min_share = 2: must be a number"));
  EXPECT_THAT(lines_, IsEmpty()) << "the error is the only line";
}

TEST_F(SettingsNames, AssignmentsAreReadAndReported) {
  sample_.items.resize(2);
  ApplySetting("tries=9", VisitRenamed(sample_));
  ApplySetting("look.mode=hard", VisitRenamed(sample_));
  ApplySetting("items.1.foreign=true", VisitRenamed(sample_));
  EXPECT_EQ(sample_.samples, 9);
  EXPECT_EQ(sample_.search.mode, "accurate");
  EXPECT_FALSE(sample_.items[0].distractor);
  EXPECT_TRUE(sample_.items[1].distractor);
  EXPECT_THAT(
      lines_,
      ElementsAre("setting 'tries=9' is deprecated, write 'samples=9'",
                  "setting 'look.mode=hard' is deprecated, write 'search.mode=accurate'",
                  "setting 'items.1.foreign=true' is deprecated, write 'items.1.distractor=true'"));
  ApplySetting("search.mode=accurate", VisitRenamed(sample_));
  EXPECT_THAT(lines_, SizeIs(3));
}

TEST_F(SettingsNames, AssignmentsReplaceNamesInsideTheirValue) {
  const auto current = [&](const char* assignment) {
    return AssignmentWithCurrentNames(assignment, VisitRenamed(sample_)).text;
  };
  EXPECT_EQ(current("items=[{foreign: true, count: 2}, {foreign: false}]"),
            "items=[{distractor: true, count: 2}, {distractor: false}]");
  EXPECT_EQ(current("look={mode: hard, least_share: 1}"), "search={mode: accurate, min_share: 1}");
  // Nothing to replace, or no valid assignment: unchanged.
  for (const char* same : {"samples=3", "other=hard", "tries", "=1", "look.mode=[hard", "a..b=1"}) {
    EXPECT_EQ(current(same), same);
  }
}

TEST_F(SettingsNames, KeysOfCachesKeepTheirFirstNames) {
  ReadSettingsText(kCurrent, "current", VisitRenamed(sample_));
  const std::string key = WriteSettingsKey(VisitRenamed(sample_));
  for (const char* name :
       {"tries: 7", "look:", "mode: \"hard\"", "least_share:", "foreign: true"}) {
    EXPECT_THAT(key, HasSubstr(name));
  }
  RenamedSample again;
  ReadSettingsText(key, "key", VisitRenamed(again));
  EXPECT_EQ(Effective(again), Effective(sample_));
}

TEST_F(SettingsNames, FilesWithAByteOrderMarkAreReplaced) {
  const auto file = temporary_.Write("mark.yaml", std::string("\xEF\xBB\xBF") + "tries: 4\n");
  ReadSettingsFile(file, VisitRenamed(sample_));
  EXPECT_EQ(sample_.samples, 4);
}

}  // namespace
}  // namespace pickbed::tests
