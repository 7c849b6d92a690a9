#pragma once

// Charts of a report as Vega-Lite 5 specifications (https://vega.github.io/vega-lite), each with
// its numbers as a table. The style of the page defines the colors. Series also differ in shape,
// dash or pattern, for black-and-white prints.
//
// Each function takes the configurations of one chart; the series have their names. A chart without
// data has no specification, and its caption says why.

#include <span>
#include <string>
#include <vector>

#include "eval/page/html.h"
#include "eval/report/run_statistics.h"

namespace pickbed::eval {

// Shares of failures by reason.
ReportChart FailureChart(std::span<const ConfigurationReport> configurations);
// One configuration: recall and pick success in one chart. Several: one chart each.
std::vector<ReportChart> VisibilityCharts(std::span<const ConfigurationReport> configurations);
// One histogram per pose error (ConfigurationReport::errors).
std::vector<ReportChart> ErrorCharts(std::span<const ConfigurationReport> configurations);
// Median of each pose error against the visible fraction of the instance, one chart per error.
std::vector<ReportChart> ErrorByBandCharts(std::span<const ConfigurationReport> configurations);
// Targets picked by hidden share, over published curves; only for occlusion trials.
ReportChart HiddenShareChart(std::span<const ConfigurationReport> configurations);
// Share of attempts that picked, by their number in the bin.
ReportChart AttemptsChart(std::span<const ConfigurationReport> configurations);
// Pick success by the fill level of the bin.
ReportChart FillChart(std::span<const ConfigurationReport> configurations);
// Rejected grasp candidates by cause.
ReportChart RejectionsChart(std::span<const ConfigurationReport> configurations);
// Share of correct poses against confidence.
ReportChart CalibrationChart(std::span<const ConfigurationReport> configurations);
// Mean time per stage and trial.
ReportChart SecondsChart(std::span<const ConfigurationReport> configurations);
// Success of each configuration; suited for many of them.
ReportChart SuccessChart(std::span<const ConfigurationReport> configurations);

}  // namespace pickbed::eval
