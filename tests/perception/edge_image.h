#pragma once

// Clouds whose color image shows the sharp edges of an object.

#include <cmath>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Returns a cloud without depth whose color image is dark, with a bright pixel at each edge point
// of the object at X_CO.
inline OrganizedCloud CloudWithEdgesOf(const CameraIntrinsics& k, const ModelPoints& model,
                                       const Pose& X_CO) {
  OrganizedCloud cloud;
  cloud.intrinsics = k;
  cloud.depth_m = Image<float>(k.width(), k.height(), 0.0f);
  cloud.color = Image<Rgb8>(k.width(), k.height(), {20, 20, 20});
  for (const EdgePoint& point : model.edges) {
    const Eigen::Vector2d at_px = Project(k, X_CO * point.p_O.cast<double>());
    const int u = static_cast<int>(std::lround(at_px.x()));
    const int v = static_cast<int>(std::lround(at_px.y()));
    // Half of the neighborhood, so that the gradient at the edge itself is not zero.
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (cloud.color.Contains(u + i, v + j)) cloud.color(u + i, v + j) = {120, 120, 120};
      }
    }
  }
  cloud.edges = FindColorEdges(k, cloud.color);
  return cloud;
}

}  // namespace pickbed::tests
