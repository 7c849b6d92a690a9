#pragma once

// Agreement of the sharp edges of a pose with the brightness edges of the image. It separates poses
// that the depth cannot separate. A flange turned by half the angle between its bolt holes has
// nearly the same depth image, but its holes have other places.

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"

namespace pickbed::perception {

struct EdgeSupport {
  double mean = 0;  // mean brightness gradient across the visible edge points, 0 .. kMaxGradient
  int visible = 0;  // number of visible edge points
};

// Stronger gradients count as this, grey levels per pixel, so that a few strong lines of the
// surroundings do not outweigh many weak ones.
inline constexpr float kMaxGradient = 6;

// Measures the edge points that face the camera and have no nearer surface in front of them. Both
// results are 0 for an image without color. Does not allocate.
EdgeSupport MeasureEdgeSupport(const OrganizedCloud& cloud, const ModelPoints& model,
                               const Pose& X_CO);

}  // namespace pickbed::perception
