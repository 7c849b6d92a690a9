#pragma once

// Output of a failure budget as text, JSON, CSV, charts and HTML page.

#include <filesystem>
#include <string>

#include "eval/budget/oracle_reruns.h"

namespace pickbed::eval {

std::string BudgetTable(const BudgetRuns& runs);  // text for the console
std::string BudgetJson(const BudgetRuns& runs);
// One line per row and reason: row, stage, reason, and counts of attempts and instances. Further
// lines give all, the picked ones and the ones not asked for. The last columns are the 95 %
// intervals of the shares of what was asked for.
std::string BudgetCsv(const BudgetRuns& runs);

// Writes budget.json, budget.csv, attempts.png, instances.png, gains.png (only with reruns) and the
// page index.html into `folder`. The files contain no times, so the same trials give the same
// bytes. Returns an empty string, or the reason why the page is missing (WritePage in
// eval/page/html.h).
[[nodiscard]] std::string WriteBudget(const std::filesystem::path& folder, const std::string& name,
                                      const BudgetRuns& runs);

}  // namespace pickbed::eval
