#pragma once

// Shapes of simple bodies, and a source that gives them.

#include <functional>

#include "grasp/completed/occupancy_shape.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Returns the occupancy of a body on a grid of `size` cells along each axis around the origin of V.
inline OccupancyShape ShapeOfBody(
    double side_m, int size, const Pose& X_WO,
    const std::function<double(const Eigen::Vector3d& p_O)>& probability) {
  OccupancyShape shape;
  shape.size = size;
  shape.cell_m = side_m / size;
  const Eigen::Vector3d corner_O = Eigen::Vector3d::Constant(-0.5 * side_m);
  shape.X_WV = X_WO * Translation(corner_O);
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const Eigen::Vector3d p_O = corner_O + shape.Center_V(x, y, z);
        shape.occupancy.push_back(static_cast<float>(probability(p_O)));
      }
    }
  }
  return shape;
}

inline OccupancyShape SphereShape(double radius_m, const Pose& X_WO, int size = 32) {
  return ShapeOfBody(2.6 * radius_m, size, X_WO,
                     [&](const Eigen::Vector3d& p) { return p.norm() < radius_m ? 1.0 : 0.0; });
}

inline OccupancyShape BoxShape(const Eigen::Vector3d& size_m, const Pose& X_WO, int size = 48) {
  return ShapeOfBody(1.3 * size_m.maxCoeff(), size, X_WO, [&](const Eigen::Vector3d& p) {
    return (p.cwiseAbs() - 0.5 * size_m).maxCoeff() < 0 ? 1.0 : 0.0;
  });
}

class GivenShapes : public ShapeSource {
 public:
  explicit GivenShapes(std::vector<OccupancyShape> shapes) : shapes_(std::move(shapes)) {}
  std::vector<OccupancyShape> Shapes(const PlannerInput&, int max_shapes) override {
    std::vector<OccupancyShape> given = shapes_;
    if (given.size() > static_cast<size_t>(max_shapes)) given.resize(max_shapes);
    return given;
  }

 private:
  std::vector<OccupancyShape> shapes_;
};

}  // namespace pickbed::tests
