#pragma once

// Shapes of simple bodies, and a source that gives them.

#include <functional>

#include "grasp/completed/occupancy_shape.h"
#include "scenes/camera/depth_points.h"
#include "tests/grasp/cloud/cloud_scene.h"
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
  explicit GivenShapes(std::vector<OccupancyShape> shapes, ImageSegments segments = {})
      : shapes_(std::move(shapes)), segments_(std::move(segments)) {}
  std::vector<OccupancyShape> Shapes(const PlannerInput&, int max_shapes) override {
    std::vector<OccupancyShape> given = shapes_;
    if (given.size() > static_cast<size_t>(max_shapes)) given.resize(max_shapes);
    return given;
  }
  ImageSegments Segments() const override { return segments_; }

 private:
  std::vector<OccupancyShape> shapes_;
  ImageSegments segments_;
};

// Returns two segments: the readings over the floor of the scene with a negative x in W, and the
// other ones. Their measures are empty.
inline ImageSegments LeftAndRight(const CloudScene& scene) {
  const RgbdFrame& frame = scene.frame();
  ImageSegments image{{frame.depth_m.width(), frame.depth_m.height(), 0}, {{}, {}}};
  ForEachDepthPoint(frame.intrinsics, frame.depth_m, [&](int u, int v, const Eigen::Vector3d& p_C) {
    const Eigen::Vector3d p_W = scene.camera().X_WC() * p_C;
    const bool is_inside = p_W.head<2>().cwiseAbs().maxCoeff() < 0.14;
    if (is_inside && p_W.z() > 0.004) image.labels(u, v) = p_W.x() < 0 ? 1 : 2;
  });
  return image;
}

}  // namespace pickbed::tests
