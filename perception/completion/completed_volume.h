#pragma once

// The occupancy of a cube around one segment, as a completion method estimates it.
//
// The cube has the axes of the camera C. Cell (0, 0, 0) is at the corner with the smallest
// coordinates. Probabilities belong to the centers of the cells.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "perception/layer.h"

namespace pickbed::perception {

struct CompletedVolume {
  Eigen::Vector3f origin_C = Eigen::Vector3f::Zero();  // corner with the smallest coordinates, m
  float cell_m = 0;                                    // side of a cell
  int size = 0;                                        // cells along each axis
  std::vector<float> occupancy;  // probability that the cell is inside, size^3 values, x fastest

  size_t Index(int x, int y, int z) const { return (static_cast<size_t>(z) * size + y) * size + x; }
  float side_m() const { return cell_m * static_cast<float>(size); }
  bool empty() const { return occupancy.empty(); }

  // Returns the center of a cell in C, m.
  Eigen::Vector3f Center_C(int x, int y, int z) const;

  // Returns the probability at a point in C (m), interpolated between the centers of the cells.
  // It is 0 outside the cube.
  float At(const Eigen::Vector3f& p_C) const;

  // Returns the derivative of At() by the point, 1/m, from differences over one cell.
  Eigen::Vector3f Gradient(const Eigen::Vector3f& p_C) const;
};

// Returns the probability above which cells should count as full, so that the expected IoU with the
// true volume is largest. The expectation is approximated by the expected volume in both over the
// expected volume in either. Cells of a certain shape are full above about 0.5, and cells of a
// doubtful one above less: the best limit is half the F1 score that it reaches (Lipton et al.,
// "Optimal thresholding of classifiers to maximize F1 measure", ECML 2014), and the same limit
// maximizes the IoU. The occupancy must be calibrated. Without any probable cell it is 0.5.
float LevelForIou(const CompletedVolume& volume);

// Returns the volume smoothed by a normal distribution with this standard deviation, in cells.
CompletedVolume Smoothed(const CompletedVolume& volume, float sigma_cells);

}  // namespace pickbed::perception
