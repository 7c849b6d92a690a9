#pragma once

// Reports of runs as one HTML file each: from the results store, and pictures where the run has
// some.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/report_data.h"
#include "eval/report_page.h"
#include "eval/report_pairs.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

struct ReportPoint {
  PointTrials trials;
  ScenarioSpec spec;
  std::string identity;  // of its store
};

struct ReportRun {
  std::string name;  // as trials are addressed: NAME#3
  std::filesystem::path folder;
  std::vector<ReportPoint> points;  // those that hold trials
  std::vector<int> crashed;         // trials
  std::vector<std::string> stops;   // which points ended early, or may, and where
};

// Throws InputError when the folder holds no results, or no finished trial.
ReportRun ReadReportRun(const std::filesystem::path& folder);

// `catalog` has the parts of the 3D views; where they cannot be loaded as they were the page has
// none and says why.
std::string RunReportPage(ReportRun run, const ObjectCatalog& catalog,
                          const ReportOptions& options = {});

struct RunComparison {
  std::string page;  // both side by side
  std::vector<PointComparison> points;
};
// Points are compared by name; a run of one point is compared with any other of one. Throws
// InputError when there is nothing to compare.
RunComparison CompareRuns(ReportRun a, ReportRun b, const ObjectCatalog& catalog,
                          const ReportOptions& options = {});

}  // namespace pickbed
