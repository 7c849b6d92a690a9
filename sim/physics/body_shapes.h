#pragma once

// Private to sim/physics: Bullet collision shapes of objects, shared by all bodies of a model.

#include <btBulletDynamicsCommon.h>

#include <map>
#include <memory>
#include <vector>

#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Bodies are built in frame B. Its origin is the center of mass, and its axes are the principal
// axes of inertia.
struct BodyFrame {
  Pose X_OB = Pose::Identity();
  Eigen::Vector3d principal_inertia;  // kg m^2
};

struct BodyShape {
  btCollisionShape* shape = nullptr;  // in frame B
  BodyFrame frame;
};

// Creates and owns the shapes.
class BodyShapes {
 public:
  // `hull_margin_m` is the distance by which pieces grow outward. It is smaller for objects under 4
  // cm.
  explicit BodyShapes(double hull_margin_m) : hull_margin_m_(hull_margin_m) {}
  // Returns the shape of a model, created at the first call. It is valid for this object's
  // lifetime.
  const BodyShape& Of(const ObjectModel& model);

 private:
  const double hull_margin_m_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::map<const ObjectModel*, BodyShape> made_;
};

}  // namespace pickbed::sim
