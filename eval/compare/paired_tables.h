#pragma once

// Paired differences of configurations on their shared scenes, as report tables, text and JSON.

#include <span>
#include <string>
#include <vector>

#include "eval/compare/paired_comparison.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"
#include "eval/summary/run_summary.h"

namespace pickbed::eval {

// Trials of one configuration, with the identity that shows whether two have the same scenes.
struct PairedConfiguration {
  const ConfigurationTrials* trials = nullptr;
  std::string identity;  // from its store, see SceneKey in eval/compare/paired_comparison.h
};

// Comparison of two configurations.
struct ConfigurationComparison {
  std::string before, after;  // names of the configurations
  PairedComparison paired;
};

// Compares two configurations. Throws InputError if they share no scene.
ConfigurationComparison CompareConfigurations(const PairedConfiguration& before,
                                              const PairedConfiguration& after);

// Compares each configuration with the first one that has the same scenes.
std::vector<ConfigurationComparison> CompareWithFirst(
    const std::vector<PairedConfiguration>& configurations);

// Returns the comparison as a table of the report.
ReportTable PairedReport(const ConfigurationComparison& comparison);
// Returns the PairedTable of each comparison, for the console.
std::string ComparisonText(std::span<const ConfigurationComparison> comparisons,
                           bool all_rows = false, const std::string& remedy = "");
// Returns {"comparisons": [{"first": NAME, "second": NAME, ... fields of PairedJson}, ...]}.
std::string ComparisonJson(std::span<const ConfigurationComparison> comparisons);
// Returns the keys of ComparisonJson().
ResultColumns ComparisonKeys();

}  // namespace pickbed::eval
