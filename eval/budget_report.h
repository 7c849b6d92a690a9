#pragma once

// A loss budget for people and programs.

#include <filesystem>
#include <string>

#include "eval/budget_run.h"

namespace pickbed {

// With fewer bins the intervals are so wide that they tell little, which is then said.
inline constexpr int kFewBins = 20;

std::string BudgetTable(const BudgetRuns& runs);  // for people
std::string BudgetJson(const BudgetRuns& runs);
// A line a row and reason: row, stage, reason, attempts, instances; with those picked and not asked
// for.
std::string BudgetCsv(const BudgetRuns& runs);

// FOLDER/budget.json, budget.csv, attempts.png, instances.png, gains.png and index.html, which
// shows them. No times: same trials, same bytes.
void WriteBudget(const std::filesystem::path& folder, const std::string& name,
                 const BudgetRuns& runs);

}  // namespace pickbed
