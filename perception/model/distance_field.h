#pragma once

// Distance to a surface on a regular grid, for millions of queries per second. It is built from
// dense surface samples by a vector distance transform (Danielsson 1980). Near the surface,
// distances are too long by at most about the sample spacing, and by much less away from it.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/layer.h"

namespace pickbed::perception {

// Distance grid of one surface, in the object frame.
struct DistanceField {
  static constexpr float kOutside_m = 1.0f;  // returned for points outside the grid

  Eigen::Vector3f origin_O = Eigen::Vector3f::Zero();  // position of node (0,0,0)
  float cell_m = 0;
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  // nodes per axis
  std::vector<float> distance_m;                   // per node, x fastest
  std::vector<uint8_t> is_inside;  // per node: 1 = more than one cell below the surface

  // Returns the unsigned distance, interpolated trilinearly; kOutside_m outside the grid.
  float At(const Eigen::Vector3f& p_O) const {
    const Eigen::Vector3f g = (p_O - origin_O) / cell_m;
    // In this form, NaN counts as outside.
    if (!(g.x() >= 0 && g.y() >= 0 && g.z() >= 0 && g.x() < size.x() - 1 && g.y() < size.y() - 1 &&
          g.z() < size.z() - 1)) {
      return kOutside_m;
    }
    const Eigen::Vector3i i = g.cast<int>();
    const Eigen::Vector3f w = g - i.cast<float>();
    const int dy = size.x(), dz = size.x() * size.y();
    const float* d = distance_m.data() + i.x() + i.y() * dy + i.z() * dz;
    const float d00 = d[0] + w.x() * (d[1] - d[0]);
    const float d10 = d[dy] + w.x() * (d[dy + 1] - d[dy]);
    const float d01 = d[dz] + w.x() * (d[dz + 1] - d[dz]);
    const float d11 = d[dz + dy] + w.x() * (d[dz + dy + 1] - d[dz + dy]);
    const float d0 = d00 + w.y() * (d10 - d00);
    const float d1 = d01 + w.y() * (d11 - d01);
    return d0 + w.z() * (d1 - d0);
  }

  // Returns the depth of a point below the surface, in metres; 0 outside the solid. Depths of less
  // than one cell read as 0. A cavity whose entrance is at most two cells wide counts as solid.
  float DepthAt(const Eigen::Vector3f& p_O) const {
    const float distance = At(p_O);
    if (distance == kOutside_m) return 0;
    const Eigen::Vector3i i =
        ((p_O - origin_O) / cell_m + Eigen::Vector3f::Constant(0.5f)).cast<int>();
    return is_inside[i.x() + size.x() * (i.y() + size.y() * i.z())] ? distance : 0;
  }
};

// Builds the field from finite surface samples (at least one). The grid has at most `nodes` nodes
// along its longest axis (at least 4) and extends `padding_m` beyond the samples. For samples at
// one place, `padding_m` must be above 0. Throws InputError otherwise.
DistanceField MakeDistanceField(std::span<const Eigen::Vector3f> samples_O, double padding_m,
                                int nodes);

}  // namespace pickbed::perception
