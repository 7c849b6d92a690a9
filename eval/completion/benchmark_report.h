#pragma once

// Output of the benchmark of shape completion: text, CSV files and an HTML page.

#include <filesystem>
#include <string>

#include "eval/completion/benchmark.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"

namespace pickbed::eval {

inline constexpr char kCompletionTable[] = "completion.csv";
inline constexpr char kCompletionViews[] = "completion_views.csv";
inline constexpr char kCompletionCalibration[] = "calibration.csv";
inline constexpr char kCompletionTimings[] = "completion_timings.csv";

// Table of IoU for the console.
std::string CompletionTableText(const CompletionBenchmark& benchmark);
// Columns of the files.
ResultColumns CompletionTableColumns();
ResultColumns CompletionViewsColumns();
ResultColumns CompletionCalibrationColumns();
ResultColumns CompletionTimingsColumns();

// Appends tables and galleries to a page, and writes its pictures and the CSV files to `folder`,
// which is created. Throws InputError if a file cannot be written.
void AddCompletionBenchmark(const std::filesystem::path& folder,
                            const CompletionBenchmark& benchmark,
                            const CompletionBenchmarkOptions& options, HtmlPage& page);

}  // namespace pickbed::eval
