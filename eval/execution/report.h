#pragma once

// Output of executed results: console tables, execution.json, and a page.

#include <string>

#include "eval/execution/statistics.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"

namespace pickbed::eval {

// Console text: success, failure reasons, paired differences, and AUC of each predictor.
std::string ExecutionText(const ExecutionStatistics& statistics);
// Returns execution.json.
std::string ExecutionJson(const ExecutionStatistics& statistics);
// Returns the keys of ExecutionJson().
ResultColumns ExecutionKeys();
// Returns the page. `what`: data set and gripper in words.
HtmlPage ExecutionPage(const ExecutionStatistics& statistics, const std::string& what);

}  // namespace pickbed::eval
