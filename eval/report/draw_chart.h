#pragma once

// Small charts and tables for contact sheets.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/image.h"

namespace pickbed {

struct ChartSeries {
  std::string name;  // in the legend; empty = not there
  std::vector<Eigen::Vector2d> points;
  Rgb8 color;
  bool dots = false;  // a dot a point, else a line through them
};

struct Chart {
  std::string x_label, y_label;
  std::vector<ChartSeries> series;
};

// Axes from the least x and from 0 to the greatest y (at least to `y_min_top`), with round ticks.
Image<Rgb8> DrawChart(const Chart& chart, int width, int height, double y_min_top = 0);

// Lines of "name<tab>value" in two columns.
Image<Rgb8> DrawTable(const std::vector<std::string>& lines, int width, int height);

// What `seen` lacks or has over `ideal`: white where they agree, red where it is farther and blue
// where nearer, full at `full_m`; black where it has no reading.
Image<Rgb8> DrawDepthError(const Image<float>& ideal_m, const Image<float>& seen_m, double full_m);

}  // namespace pickbed
