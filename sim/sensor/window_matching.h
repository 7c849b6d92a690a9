#pragma once

// Effects of matching windows instead of single pixels: correlated errors and dropout of
// neighboring pixels, and dropout around edges.

#include <cstdint>
#include <vector>

#include "scenes/image/image.h"
#include "sim/sensor/noise_streams.h"

namespace pickbed::sim {

// Random fields of unit variance. Independent numbers `spacing_px` apart are interpolated
// bilinearly and scaled by the norm of the four weights. The correlation along x or y, averaged
// over all positions, is pi/4 - 1/2 = 0.285 at one spacing and 0 from two spacings on.
class CorrelatedNumbers {
 public:
  // `key` is the first place used in a sequence of 2^64 numbers.
  CorrelatedNumbers(uint64_t key, int width, double spacing_px);
  // Replaces all numbers of row y except `flying`. Rows must be requested in ascending order.
  void Fill(int y, SensorNumbers& numbers);

 private:
  struct Knots {
    SensorNumbers errors, dropout;  // only `along` of dropout is used
    int row;
  };
  void Draw(int row, Knots& knots) const;
  void Blend(const std::vector<float>& upper, const std::vector<float>& lower, float share,
             std::vector<float>& out);

  uint64_t key_;
  double spacing_px_;
  int count_;  // knots per row
  Knots upper_, lower_;
  std::vector<int> left_;                          // index of the knot to the left of each pixel
  std::vector<float> left_weight_, right_weight_;  // of the left knot and the next
  std::vector<float> row_;                         // knots interpolated between two rows of knots
};

// Returns the distance of each pixel to the nearest edge, in pixels: the larger one of its x and y
// distances, limited to `farthest`. A window of half width r sees an edge up to distance r. Edges
// are defined by EdgeRow() (image_geometry.h); their own pixels have distance 0.
Image<uint8_t> EdgeDistances_px(const Image<float>& depth_m, float step_m, uint8_t farthest);

}  // namespace pickbed::sim
