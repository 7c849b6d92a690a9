#pragma once

// Names the settings in which two runs differ.

#include <string>
#include <vector>

namespace pickbed::eval {

// A setting with different values in two settings texts.
struct SettingDifference {
  std::string key;          // such as "estimator.mode"; a hash has its key in the text
  std::string before, now;  // "nothing" if the text has no such setting
};

// Compares two settings texts. Returns the differences in the order of the first text.
std::vector<SettingDifference> DifferentSettings(const std::string& before, const std::string& now);

// Returns what a key describes: the key itself for a setting, words for a hash.
std::string SettingInWords(const std::string& key);

// Compares two settings texts (YAML, as WriteSettings() writes it, and the hashes of
// eval/sweep/run.h). Returns one text per difference, such as "estimator.mode: fast before,
// accurate now".
std::vector<std::string> SettingsDifferences(const std::string& before, const std::string& now);

}  // namespace pickbed::eval
