#pragma once

// Output of the crop benchmark as text, CSV and HTML page.

#include <string>

#include "eval/benchmark/crops_statistics.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"

namespace pickbed::eval {

inline constexpr char kCropsFile[] = "crops.csv";
inline constexpr char kCropViewsFile[] = "views.csv";
inline constexpr char kCropDifferencesFile[] = "differences.csv";
inline constexpr char kCropSettingsFile[] = "settings.yaml";
inline constexpr char kCropsPage[] = "crops.html";

// Main statistics over all objects, one block per condition.
std::string CropTableText(const CropBenchmark& benchmark);
// One line per method, stage, condition and object, and one for all objects; with 95 % intervals.
std::string CropTableCsv(const CropBenchmark& benchmark, const ObjectSet& objects);
// One line per test view, method and stage.
std::string CropViewsCsv(const CropBenchmark& benchmark, const ObjectSet& objects);
// Times in seconds. The other files contain no times.
std::string CropTimingsCsv(const CropBenchmark& benchmark);
// Difference between the rates of each method and each later one, paired over test views.
std::string CropDifferencesCsv(const CropBenchmark& benchmark);
// Returns the columns of CropTableCsv().
ResultColumns CropTableColumns();
// Returns the columns of CropViewsCsv().
ResultColumns CropViewsColumns();
// Returns the columns of CropTimingsCsv().
ResultColumns CropTimingsColumns();
// Returns the columns of CropDifferencesCsv().
ResultColumns CropDifferencesColumns();
// HTML page. `settings` is the text of the settings in use.
HtmlPage CropPage(const CropBenchmark& benchmark, const ObjectSet& objects,
                  const std::string& settings);

}  // namespace pickbed::eval
