#pragma once

// A loss budget for people and programs.

#include <filesystem>
#include <string>

#include "eval/budget_run.h"

namespace pickbed {

std::string BudgetTable(const BudgetRuns& runs);  // for people
std::string BudgetJson(const BudgetRuns& runs);
// A line a row and reason: row, stage, reason, attempts, instances; with all, those picked and
// those not asked for; then the 95 % intervals of the shares of what was asked for.
std::string BudgetCsv(const BudgetRuns& runs);

// FOLDER/budget.json, budget.csv, attempts.png, instances.png, gains.png and index.html, which
// shows them. No times: same trials, same bytes.
void WriteBudget(const std::filesystem::path& folder, const std::string& name,
                 const BudgetRuns& runs);

}  // namespace pickbed
