#pragma once

// Output of a failure budget as text, JSON, CSV, charts and HTML page.

#include <filesystem>
#include <string>

#include "eval/budget/oracle_reruns.h"
#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

// Files in kBudgetFolder of a results folder.
inline constexpr char kBudgetFile[] = "budget.csv";
inline constexpr char kBudgetJsonFile[] = "budget.json";
inline constexpr char kAttemptsSheet[] = "attempts.png";
inline constexpr char kInstancesSheet[] = "instances.png";
inline constexpr char kGainsSheet[] = "gains.png";

std::string BudgetTable(const BudgetRuns& runs);  // text for the console
// Returns the counts, shares and gains as JSON.
std::string BudgetJson(const BudgetRuns& runs);
// One line per row and reason: row, stage, reason, and counts of attempts and instances. Further
// lines give all, the picked ones and the ones not asked for. The last columns are the 95 %
// intervals of the shares of what was asked for.
std::string BudgetCsv(const BudgetRuns& runs);
// Returns the columns of BudgetCsv().
ResultColumns BudgetColumns();
// Returns the keys of BudgetJson().
ResultColumns BudgetKeys();

// Writes budget.json, budget.csv, attempts.png, instances.png, gains.png (only with reruns) and the
// page index.html into `folder`. The files contain no times, so the same trials give the same
// bytes. Returns an empty string, or the reason why the page is missing (WritePage in
// eval/page/html.h).
[[nodiscard]] std::string WriteBudget(const std::filesystem::path& folder, const std::string& name,
                                      const BudgetRuns& runs);

}  // namespace pickbed::eval
