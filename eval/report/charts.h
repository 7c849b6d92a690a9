#pragma once

// The charts of a report as Vega-Lite 5 specifications (https://vega.github.io/vega-lite), each
// with its numbers as a table. Colours stand in the page's style; series are told apart by shape,
// dash or pattern as well, for print in black and white.
//
// Each takes the points that are to be seen together; series are named by them. A chart of which
// there is nothing to show has no specification, and its caption says why.

#include <span>
#include <string>
#include <vector>

#include "eval/report_data.h"

namespace pickbed {

using TableCells = std::vector<std::vector<std::string>>;  // the first row is the header

struct ReportChart {
  std::string id;  // for tests and links; [a-z-]
  std::string title;
  std::string caption;
  std::string spec;  // JSON; empty = nothing to show
  TableCells table = {};
};

ReportChart LossChart(std::span<const PointReport> points);
// Recall and pick success of one point in one chart; of several in one chart each.
std::vector<ReportChart> VisibilityCharts(std::span<const PointReport> points);
std::vector<ReportChart> ErrorCharts(std::span<const PointReport> points);
ReportChart CalibrationChart(std::span<const PointReport> points);
ReportChart SecondsChart(std::span<const PointReport> points);
// Success of each point, best seen where there are many.
ReportChart SuccessChart(std::span<const PointReport> points);

// One series of a chart of rates: a rate for each name along x.
struct RateCurve {
  std::string series;
  std::vector<ReportRate> rates;
};
// Curves with their intervals over names in the order given, and the table of their numbers. The
// chart's id, title and caption are taken as they are.
ReportChart RateCurves(ReportChart chart, const std::string& x_title, const std::string& y_title,
                       const std::vector<std::string>& x_names,
                       const std::vector<RateCurve>& curves);

// "12.5 % [8.1, 18.4]", or "-" of nothing.
std::string RateText(const ReportRate& rate);

}  // namespace pickbed
