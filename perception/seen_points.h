#pragma once

// Which points of a part an image shows at a pose: there the colours of the two can be compared.

#include <vector>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"

namespace pickbed {

struct SeenPoint {
  int point = 0;  // index into ModelPoints::points_O
  int pixel = 0;
};

// The first 400 of the visible points that face the camera and have a reading on their surface.
std::vector<SeenPoint> SeenPoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                  const Pose& X_CO);

}  // namespace pickbed
