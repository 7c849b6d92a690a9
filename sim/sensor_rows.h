#pragma once

// The geometry that a sensor's effects depend on, row by row of an ideal depth image and without
// chance: slants, edges, and what a projector or second camera cannot see.

#include <cstdint>
#include <vector>

#include "scenes/camera.h"
#include "scenes/image.h"

namespace pickbed {

// Slant of each pixel of one row: angle between the surface's normal and the ray to the pixel, rad.
// On a plane the inverse depth q is linear in the image, q = n.(x, y, 1) with normalised image
// coordinates x, y and a normal n of length 1 / distance, so that n follows from two differences of
// q and the cosine is q / (|n| |(x, y, 1)|). Of the differences to the two sides the smaller
// counts, so that a pixel at an edge has the slant of its own surface. Where there is no depth, any
// value.
class SlantRows {
 public:
  SlantRows(const Image<float>& depth_m, const CameraIntrinsics& intrinsics);
  // The slants of row y, valid until the next call. Rows must be asked for in rising order from 0.
  const float* Row(int y);

 private:
  void LoadInverseDepth(int y);

  const Image<float>& depth_m_;
  CameraIntrinsics intrinsics_;
  std::vector<float> inverse_[3];  // of rows y - 1, y, y + 1 modulo 3, with a border of one
  std::vector<float> outside_;     // beyond the first or last row
  std::vector<float> ray_x_;
  std::vector<float> slant_rad_;
};

// 1 where the depth differs by more than `step_m` from one of the 4 neighbours inside the image.
void EdgeRow(const Image<float>& depth_m, int y, float step_m, uint8_t* is_edge);

// What stands between the points of one row and a projector (or second camera) at `baseline_m`
// along camera x. Its column for a point seen at column u is u - f b / z. On each of its columns
// the nearest surface is drawn, every pixel of it as far as half way to its neighbours (half a
// pixel where an edge parts them), and a point is in shadow when what is drawn at its column is
// nearer by more than one pixel of disparity: what is less in front casts a shadow less than a
// pixel wide. Behind a step from z1 to z2 the shadow is f b (1/z1 - 1/z2) wide. What lies outside
// of the image casts none.
class ShadowRows {
 public:
  // edge_step_m as of EdgeRow.
  ShadowRows(int width, double fx, double baseline_m, float edge_step_m);
  void Row(const float* depth_m, uint8_t* is_shadow);

 private:
  int width_;
  float focal_times_baseline_;
  float edge_step_m_;
  std::vector<float> nearest_;  // largest disparity on each of the projector's columns
  std::vector<float> disparity_, column_;
  std::vector<float> is_gap_;      // between a pixel and the next
  std::vector<int> first_, last_;  // columns that a pixel is drawn on
};

}  // namespace pickbed
