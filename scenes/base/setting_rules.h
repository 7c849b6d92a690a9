#pragma once

// Rules of settings, and their wording: shared by the readers, the writer and the check.

#include <string>
#include <vector>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

std::string RangeText(Range range);     // "from 0 to 1"
bool IsIn(Range range, double number);  // NaN is in no range
// Returns "must be a number from 0 to 1 (HELP)".
std::string NumberRule(Range range, const char* help);
// Any value is allowed without choices.
bool IsChoice(const std::string& value, const std::vector<std::string>& choices);

}  // namespace pickbed::scenes
