#pragma once

// Plots and tables for pictures. (Charts of HTML pages are in eval/page/vega.h.)

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "eval/draw/canvas.h"
#include "eval/stats/statistics.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Maps values linearly to pixels.
class PlotAxis {
 public:
  // Maps `min` to `first_px` and `max` to `last_px`. Throws std::logic_error unless min < max.
  PlotAxis(double min, double max, double first_px, double last_px);
  double min() const { return min_; }
  double max() const { return max_; }
  double At(double value) const;       // px
  double ValueAt(double at_px) const;  // inverse of At

 private:
  double min_, max_, first_px_, last_px_;
};

// Draws vertical grid lines at round values from `top_px` to `bottom_px`, the values below them,
// and the label of the axis below these.
void DrawXAxis(Canvas& canvas, const PlotAxis& axis, int top_px, int bottom_px,
               const std::string& label);
// Draws horizontal grid lines at round values from `left_px` to `right_px`, and the values on the
// left. If `percent`, the values are shares.
void DrawYAxis(Canvas& canvas, const PlotAxis& axis, int left_px, int right_px, bool percent);

// Points of one curve.
struct ChartSeries {
  std::string name;  // legend text; empty = not in the legend
  std::vector<Eigen::Vector2d> points;
  Rgb8 color;
  bool dots = false;                // dots, else a polyline
  std::vector<Interval> band = {};  // interval of each point, shaded if it is known; empty = none
};

struct Chart {
  std::string x_label, y_label;
  std::vector<ChartSeries> series;
  bool percent = false;                   // y values are shares; the axis shows 0 to 100 %
  std::optional<Interval> marked_x = {};  // range of x with a green background
};

// Draws a chart. The x axis covers the data. The y axis is from 0 to a little over the maximum y,
// at least `y_min_top`.
Image<Rgb8> DrawChart(const Chart& chart, int width, int height, double y_min_top = 0);

// Draws lines of "name<tab>value" in two columns.
Image<Rgb8> DrawTable(const std::vector<std::string>& lines, int width, int height);

// Depth error of `seen` relative to `ideal`: white = equal, red = further, blue = closer, saturated
// at `full_m`. Black where `seen` has no reading.
Image<Rgb8> DrawDepthError(const Image<float>& ideal_m, const Image<float>& seen_m, double full_m);

}  // namespace pickbed::eval
