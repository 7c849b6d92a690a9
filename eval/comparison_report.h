#pragma once

// A comparison as text, as CSV and as a page.

#include <string>
#include <vector>

#include "eval/comparison.h"

namespace pickbed {

std::string ComparisonTable(const std::vector<ComparedRow>& rows);
// A line a row and part, and one a row for all parts.
std::string ComparisonCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects);
// A line a reported pose.
std::string HypothesesCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects);
// `pictures`: overlays to show, as seen from the page.
std::string ComparisonPage(const std::string& title, const std::vector<ComparedRow>& rows,
                           const ObjectSet& objects, const std::vector<std::string>& pictures);

}  // namespace pickbed
