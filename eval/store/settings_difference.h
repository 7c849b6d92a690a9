#pragma once

// Names the settings in which two runs differ.

#include <string>
#include <vector>

namespace pickbed::eval {

// Compares two settings texts (YAML, as WriteSettings() writes it, and the hashes of
// eval/sweep/run.h). Returns one text per difference, such as "estimator.mode: fast before,
// accurate now".
std::vector<std::string> SettingsDifferences(const std::string& before, const std::string& now);

}  // namespace pickbed::eval
