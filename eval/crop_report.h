#pragma once

// The crop table as text, as CSV and as a page.

#include <string>

#include "eval/crop_figures.h"

namespace pickbed {

// The main figures of all parts, a block a condition.
std::string CropTableText(const CropBenchmark& benchmark);
// A line a method, stage, condition and part, and one for all parts; with 95 % intervals.
std::string CropTableCsv(const CropBenchmark& benchmark, const ObjectSet& objects);
// A line a test view and method.
std::string CropViewsCsv(const CropBenchmark& benchmark, const ObjectSet& objects);
// Seconds, which stand nowhere else.
std::string CropTimingsCsv(const CropBenchmark& benchmark);
// By how much each method's share exceeds each later one's, paired over test views.
std::string CropDifferencesCsv(const CropBenchmark& benchmark);
// Throws InputError when this build has no page to fill in. `settings`: those in force.
std::string CropPage(const CropBenchmark& benchmark, const ObjectSet& objects,
                     const std::string& settings);

}  // namespace pickbed
