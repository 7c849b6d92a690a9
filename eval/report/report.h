#pragma once

// Reports of runs, one HTML file each. They are made from the results store and the pictures in its
// folder.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/compare/paired_tables.h"
#include "eval/report/run_page.h"
#include "eval/report/run_statistics.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// One configuration of a run or sweep.
struct ReportConfiguration {
  ConfigurationTrials trials;
  ScenarioSpec spec;
  std::string identity;  // identity from its store
};

// A results folder with its trials.
struct ReportRun {
  std::string name;  // prefix of trial addresses: NAME#3
  std::filesystem::path folder;
  std::vector<ReportConfiguration> configurations;  // configurations with finished trials
  std::vector<int> crashed;                         // trial numbers
  std::vector<std::string> stops;  // one sentence per configuration with an early stop
};

// Reads a results folder. Throws InputError if it holds no results or no finished trial.
ReportRun ReadReportRun(const std::filesystem::path& folder);

// Returns the report page of a run or sweep. `catalog` provides the objects for the 3D views. If
// they cannot be loaded as in the run, the page has no views and states the reason.
std::string RunReportPage(ReportRun run, const ObjectCatalog& catalog,
                          const ReportOptions& options = {});

// Comparison of two runs.
struct RunComparison {
  std::string page;  // HTML page with both runs
  std::vector<ConfigurationComparison> configurations;
};
// Compares two runs or sweeps. Configurations are paired by name; two runs with one configuration
// each are always paired. Throws InputError if there is nothing to compare.
RunComparison CompareRuns(ReportRun a, ReportRun b, const ObjectCatalog& catalog,
                          const ReportOptions& options = {});

}  // namespace pickbed::eval
