#pragma once

// Output of the benchmark of shape completion: text, CSV files and an HTML page.

#include <filesystem>
#include <string>

#include "eval/completion/benchmark.h"
#include "eval/metrics/result_columns.h"

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

// Writes index.html, its pictures and the CSV files to `folder`, which is created. Returns an empty
// string, or the reason why the page is missing. Throws InputError if a file cannot be written.
[[nodiscard]] std::string WriteCompletionBenchmark(const std::filesystem::path& folder,
                                                   const CompletionBenchmark& benchmark,
                                                   const CompletionBenchmarkOptions& options);

}  // namespace pickbed::eval
