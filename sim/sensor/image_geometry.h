#pragma once

// Deterministic geometry for sensor effects, row by row of an ideal depth image: slants, edges, and
// the shadow of a projector or second camera.

#include <cstdint>
#include <vector>

#include "scenes/camera/camera.h"
#include "scenes/image/image.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Computes the slant of each pixel of a row: the angle in rad between surface normal and pixel ray.
// Pixels without depth get an arbitrary value.
//
// On a plane, the inverse depth q is linear in the image: q = n.(x, y, 1). Here x and y are
// normalized image coordinates, and n is the normal with length 1 / distance. So n follows from two
// differences of q, and the cosine is q / (|n| |(x, y, 1)|). The smaller difference of both sides
// is used, so that an edge pixel gets the slant of its own surface.
class SlantRows {
 public:
  SlantRows(const Image<float>& depth_m, const CameraIntrinsics& intrinsics);
  // Returns the slants of row y, valid until the next call. Rows must be requested in ascending
  // order from 0.
  const float* Row(int y);

 private:
  void LoadInverseDepth(int y);

  const Image<float>& depth_m_;
  CameraIntrinsics intrinsics_;
  std::vector<float> inverse_[3];  // rows y - 1, y, y + 1 modulo 3, with a border of one
  std::vector<float> outside_;     // extrapolated row outside the image
  std::vector<float> ray_x_;
  std::vector<float> slant_rad_;
};

// Sets 1 where the depth differs by more than `step_m` from a 4-neighbor inside the image.
void EdgeRow(const Image<float>& depth_m, int y, float step_m, uint8_t* is_edge);

// Finds the pixels of a row that are in the shadow of a projector (or second camera) at
// `baseline_m` along camera x. It sees a point of image column u at its column u - f b / z.
//
// The nearest surface is drawn on each of its columns. A pixel covers half the way to its
// neighbors, or half a pixel at an edge. A point is in shadow if the surface at its column is
// nearer by more than one pixel of disparity. A smaller step casts a shadow narrower than one
// pixel. The shadow behind a step from z1 to z2 is f b (1/z1 - 1/z2) wide. Surfaces outside the
// image cast no shadow.
class ShadowRows {
 public:
  // `edge_step_m` has the meaning of step_m in EdgeRow().
  ShadowRows(int width, double fx, double baseline_m, float edge_step_m);
  // Sets `is_shadow` to 1 for the pixels in shadow, else to 0. Both arrays have `width` elements.
  void Row(const float* depth_m, uint8_t* is_shadow);

 private:
  int width_;
  float focal_times_baseline_;
  float edge_step_m_;
  std::vector<float> nearest_;  // largest disparity on each projector column
  std::vector<float> disparity_, column_;
  std::vector<float> is_gap_;      // between a pixel and the next
  std::vector<int> first_, last_;  // columns that a pixel covers
};

}  // namespace pickbed::sim
