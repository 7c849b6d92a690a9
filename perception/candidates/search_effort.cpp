#include "perception/candidates/search_effort.h"

#include <algorithm>

namespace pickbed::perception {

double LargestSilhouette_m2(const ModelPoints& model) {
  double largest_m2 = 0;
  for (size_t d = 0; d < model.directions_O.size(); ++d) {
    double sum_m2 = 0;
    for (const uint16_t point : model.visible[d]) {
      const float facing = model.normals_O[point].dot(model.directions_O[d]);
      sum_m2 += model.area_per_point_m2 * std::max(0.0f, facing);
    }
    largest_m2 = std::max(largest_m2, sum_m2);
  }
  return largest_m2;
}

double AreaOf_m2(const OrganizedCloud& cloud, const std::vector<int>& pixels) {
  double sum_m2 = 0;
  for (const int pixel : pixels) {
    const double z_m = cloud.points_C[pixel].z();
    sum_m2 += z_m * z_m;
  }
  return sum_m2 / (cloud.intrinsics.fx() * cloud.intrinsics.fy());
}

}  // namespace pickbed::perception
