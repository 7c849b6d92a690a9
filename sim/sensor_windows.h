#pragma once

// What becomes of a sensor's noise where it matches windows of pixels and not single ones: errors
// and losses of neighbours that are alike, and losses all around an edge.

#include <cstdint>
#include <vector>

#include "scenes/image.h"
#include "sim/sensor_numbers.h"

namespace pickbed {

// Random fields of unit variance everywhere: bilinear between independent numbers `spacing_px`
// apart, scaled by the length of the four weights. Their correlation along x or y, in the mean over
// all places, is pi/4 - 1/2 = 0.285 at one spacing and 0 from two on.
class CorrelatedNumbers {
 public:
  // `key`: the place in a sequence of 2^64 from which on the numbers are taken.
  CorrelatedNumbers(uint64_t key, int width, double spacing_px);
  // Puts those of row y in place of all numbers of `numbers` but `flying`. Rows must be asked for
  // in rising order.
  void Fill(int y, SensorNumbers& numbers);

 private:
  struct Knots {
    SensorNumbers errors, losses;  // `along` of losses counts alone
    int row;
  };
  void Draw(int row, Knots& knots) const;
  void Blend(const std::vector<float>& upper, const std::vector<float>& lower, float share,
             std::vector<float>& out);

  uint64_t key_;
  double spacing_px_;
  int count_;  // of knots in a row
  Knots upper_, lower_;
  std::vector<int> left_;                          // knot to the left of each pixel
  std::vector<float> left_weight_, right_weight_;  // of it and of the next
  std::vector<float> row_;                         // knots of a row between two rows of them
};

// How many pixels away the nearest edge is, in x or y, whichever is more: a window of half width r
// sees an edge at up to r. An edge is as of EdgeRow (sensor_rows.h), its pixels are at 0, and
// `farthest` stands for all that is more.
Image<uint8_t> EdgeDistances_px(const Image<float>& depth_m, float step_m, uint8_t farthest);

}  // namespace pickbed
