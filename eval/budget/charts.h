#pragma once

// Charts of a failure budget for its page. eval/budget/draw.h draws the same data as pictures.

#include <string>
#include <vector>

#include "eval/budget/oracle_reruns.h"
#include "eval/page/html.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {

// A step of the waterfall from all picks down to the successful ones.
struct WaterfallStep {
  std::string name;   // failure reason
  std::string group;  // stage; steps of one stage have the same color
  int count = 0;
  Interval ci95;  // of its share
};
struct Waterfall {
  std::string title;
  std::string whole;   // what the shares are of, for example "all attempts"
  std::string all;     // name of the first bar
  WaterfallStep left;  // last bar: the remaining picks
  int total = 0;       // sum of the counts of all steps and `left`
  std::vector<WaterfallStep> steps;
};

// "+12.5 [+8.1, +18.4]", in percentage points.
std::string GainText(const Gain& gain);

// Gains of a rerun: two series, each with its interval.
struct GainRow {
  std::string name;
  Gain first, second;
};
struct GainRows {
  std::string title;
  std::string first, second;  // legend texts of the two series
  std::vector<GainRow> rows;
};

// Returns a bar from 0 to 100 %, one bar per step, and the remaining picks at the bottom. Each step
// starts where the previous one ends; a line shows the interval of its end.
ReportChart WaterfallChart(const std::string& id, const Waterfall& waterfall);

// Returns one point with its interval per row and series.
ReportChart GainsChart(const std::string& id, const GainRows& gains);

}  // namespace pickbed::eval
