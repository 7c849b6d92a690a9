#pragma once

// Charts of the pages as Vega-Lite 5 specifications (https://vega.github.io/vega-lite): shared
// elements, and the charts of curves. The page template defines the style. Series also differ in
// shape, dash or pattern, for black-and-white prints.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/page/html.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {

using Json = nlohmann::ordered_json;

// Returns a data field with the title of its axis or legend.
Json Field(const char* name, const char* type, const std::string& title);
// Returns a share as an axis in percent. If `whole`, the axis covers 0 to 100 %, else the range of
// the data.
Json PercentField(const char* name, const std::string& title, bool whole = true);

// Returns a specification with data and width, to be completed by the caller.
Json EmptySpec(const Json& values);
// Height of a chart of horizontal bars: `rows` rows with one bar per series. (A step height cannot
// be combined with a width that follows the page.)
int BarsHeight_px(size_t rows, size_t series);

// Encoding of a series by color. These three add a legend if there are several series.
Json SeriesColor(const char* field, const std::vector<std::string>& names);
// Encoding of a series by the shape of its points.
Json SeriesShape(const char* field, const std::vector<std::string>& names);
// Encoding of a series by the dash of its line.
Json SeriesDash(const char* field, const std::vector<std::string>& names);
// Fill of bars: a color with a pattern.
Json SeriesFill(const char* field, const std::vector<std::string>& names);

// Adds `rate`, its interval `low` and `high` if it is known, and `text` to a data value.
void AddRate(const ReportRate& rate, Json& value);
// Returns the layer without the data values whose interval is unknown.
Json WithInterval(Json layer);

// Layers of a curve with its interval band. `x` is ordinal or quantitative. The data fields are
// `rate`, `low`, `high` and `series`.
Json CurveLayers(const Json& x, const Json& y, const std::vector<std::string>& names);

// Layers of points with interval bars, side by side for the series of a name, without lines. `x` is
// ordinal. The data fields are the ones of CurveLayers().
Json PointLayers(const Json& x, const Json& y, const std::vector<std::string>& names);

// What the names on an x axis are.
enum class AxisNames {
  kOrdered,    // places on a scale: points are joined by lines
  kCategories  // kinds of things without an order: points with bars
};

// One series of a rate chart: one rate per name on the x axis.
struct RateCurve {
  std::string series;
  std::vector<ReportRate> rates;
};
// Appearance of RateCurves.
struct RateCurvesStyle {
  int height_px = 260;
  const RateCurve* reference = nullptr;  // drawn in gray behind the others, without intervals
  AxisNames x_names = AxisNames::kOrdered;
};
// Completes `chart` with curves and intervals over `x_names`, in this order, and with the table of
// their numbers. Id, title and caption are kept.
ReportChart RateCurves(ReportChart chart, const std::string& x_title, const std::string& y_title,
                       const std::vector<std::string>& x_names,
                       const std::vector<RateCurve>& curves, const RateCurvesStyle& style = {});

// One series of a chart of values: one value per name on the x axis, NaN = none.
struct NamedValueCurve {
  std::string series;
  std::vector<double> values;
  std::vector<Interval> intervals;
  std::vector<std::string> texts;  // value and interval, for the table
  std::vector<int> samples;
};
// Completes `chart` like RateCurves, for values with a unit. The y axis begins at 0. It ends at the
// largest value, but not below `min_y_end`, so that rounding errors do not fill the chart.
ReportChart NamedValueCurves(ReportChart chart, const std::string& x_title,
                             const std::string& y_title, const std::vector<std::string>& x_names,
                             const std::vector<NamedValueCurve>& curves, double min_y_end = 0,
                             AxisNames kind = AxisNames::kOrdered);

// Rate of correct poses among the poses with about the same confidence.
struct CalibrationPoint {
  double confidence = 0;  // mean
  ReportRate right;
};
struct CalibrationCurve {
  std::string series;
  std::vector<CalibrationPoint> points;
};
// Completes `chart` with the rates against the confidence, and the diagonal on which both are
// equal. Adds a row per point to the table: series, confidence, rate, number of poses.
ReportChart CalibrationCurves(ReportChart chart, const std::string& x_title,
                              const std::string& y_title,
                              const std::vector<CalibrationCurve>& curves);

// A value that is not a rate, with its range.
struct ValuePoint {
  double x = 0, y = 0;
  double low = 0, high = 0;  // low = high = y: no range
};
struct ValueCurve {
  std::string series;
  std::vector<ValuePoint> points;
};
// Completes `chart` with curves of values over numbers, and with the table of their numbers.
// The y axis begins at 0 and ends at `y_max`, or at the largest value if `y_max` is 0.
ReportChart ValueCurves(ReportChart chart, const std::string& x_title, const std::string& y_title,
                        const std::vector<ValueCurve>& curves, double y_max = 0);

}  // namespace pickbed::eval
