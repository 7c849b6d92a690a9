#pragma once

// How much there is to search: foreground and silhouettes. The foreground over the largest
// silhouette of an instance is a lower bound of the number of visible instances.

#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"

namespace pickbed::perception {

// Returns the area of the model's silhouette, m^2, as the largest over all viewing directions.
double LargestSilhouette_m2(const ModelPoints& model);

// Returns the area of the pixels, m^2, as seen by the camera.
double AreaOf_m2(const OrganizedCloud& cloud, const std::vector<int>& pixels);

}  // namespace pickbed::perception
