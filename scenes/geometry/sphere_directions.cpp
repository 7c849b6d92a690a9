#include "scenes/geometry/sphere_directions.h"

#include <cmath>
#include <numbers>

namespace pickbed::scenes {

std::vector<Eigen::Vector3d> SphereDirections(int count) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(count);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count;
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    directions.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return directions;
}

}  // namespace pickbed::scenes
