#include "eval/summary/run_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/summary/run_summary.h"
#include "tests/eval/full_trial.h"

namespace pickbed::tests {
namespace {

// Whether a path such as "tools.jaw_8cm.rate" is an entry such as "tools.GRIPPER.rate".
bool IsKey(const std::string& path, const std::string& key) {
  std::istringstream words(path), names(key);
  std::string word, name;
  while (std::getline(names, name, '.')) {
    if (!std::getline(words, word, '.')) return false;
    if (name.ends_with("[]")) name.resize(name.size() - 2);
    const bool is_any = std::ranges::all_of(name, [](char c) { return c >= 'A' && c <= 'Z'; });
    if (!is_any && name != word) return false;
  }
  return !std::getline(words, word, '.');
}

// The reference lists every key of summary.json.
TEST(SummaryJson, EachKeyIsDescribed) {
  std::vector<TrialResult> trials{FullTrial(0), FullTrial(1)};
  int attempts = 0;
  for (TrialResult& trial : trials) {
    for (AttemptRecord& attempt : trial.attempts) {
      if (attempt.grasp) attempt.grasp->tool = ++attempts % 2 == 0 ? "jaw_8cm" : "cup_30mm";
    }
  }
  const auto json = nlohmann::json::parse(SummaryJson(Summarize(trials)));
  EXPECT_TRUE(json.contains("tools") && json.contains("clutter") && json.contains("retention"));
  const nlohmann::json flat = json.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    if (json.at(nlohmann::json::json_pointer(pointer)).is_array()) continue;  // empty
    std::string path;
    std::istringstream words(pointer.substr(1));
    for (std::string word; std::getline(words, word, '/');) {
      const bool is_index = std::ranges::all_of(word, [](char c) { return std::isdigit(c); });
      if (!is_index) path += (path.empty() ? "" : ".") + word;
    }
    EXPECT_TRUE(std::ranges::any_of(SummaryKeys(), [&](const ResultColumn& column) {
      return IsKey(path, column.name);
    })) << path;
  }
}

}  // namespace
}  // namespace pickbed::tests
