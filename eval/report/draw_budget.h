#pragma once

// A loss budget as pictures.

#include <string>
#include <vector>

#include "scenes/image.h"

namespace pickbed {

// A step of the way from all picks down to those achieved.
struct WaterfallStep {
  std::string name;   // the reason
  std::string group;  // the stage; steps of one stage have one colour
  int count = 0;
  double low = 0, high = 0;  // 95 % interval of its share, %
};
struct Waterfall {
  std::string title;
  std::string unit;    // of the axis: "% of attempts"
  std::string all;     // name of the whole
  WaterfallStep left;  // what is left in the end
  int total = 0;       // the steps take all but `left` from it
  std::vector<WaterfallStep> steps;
};
// A bar from 0 to 100 %, below it each step's loss where it takes away, in the stage's colour, and
// at the bottom what is left, each with number, share and interval.
Image<Rgb8> DrawWaterfall(const Waterfall& waterfall);

// Dots with intervals along one axis of points, a line a row, two kinds in two colours.
struct GainDot {
  double points = 0, low = 0, high = 0;
};
struct GainRow {
  std::string name;
  GainDot first, second;
};
struct GainChart {
  std::string title, x_label;
  std::string first, second;  // what the two kinds are
  std::vector<GainRow> rows;
};
Image<Rgb8> DrawGains(const GainChart& chart);

}  // namespace pickbed
