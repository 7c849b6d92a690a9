#pragma once

// Intervals over bins need bins: of few they are wide, and those of an AUC by bootstrap too narrow,
// as a resample of a few bins varies less than new bins would.

#include <string>

namespace pickbed {

inline constexpr int kFewBins = 20;

// A sentence that says so where there are less than kFewBins; else empty.
std::string FewBinsText(int bins);

}  // namespace pickbed
