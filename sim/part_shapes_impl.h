#pragma once

// Private to sim's physics: the shapes of parts in Bullet, one for all bodies of a model.

#include <btBulletDynamicsCommon.h>

#include <map>
#include <memory>
#include <vector>

#include "scenes/object_model.h"
#include "scenes/pose.h"

namespace pickbed {

// Bodies are built in frame B: origin at the centre of mass, axes along the principal ones.
struct PartFrame {
  Pose X_OB = Pose::Identity();
  Eigen::Vector3d principal_inertia;  // kg m^2
};

struct PartShape {
  btCollisionShape* shape = nullptr;  // in B
  PartFrame frame;
};

class PartShapes {
 public:
  // The margin by which pieces grow outward; less for parts under 4 cm.
  explicit PartShapes(double hull_margin_m) : hull_margin_m_(hull_margin_m) {}
  // Valid as long as this lives.
  const PartShape& Of(const ObjectModel& model);

 private:
  const double hull_margin_m_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::map<const ObjectModel*, PartShape> made_;
};

}  // namespace pickbed
