#pragma once

// Exact depth images of objects in a bin, for planners without poses.

#include "grasp/plan/planner.h"
#include "scenes/camera/camera.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {

// A bin of 300 x 300 x 50 mm, seen from above and a little from the side, with ray-cast objects.
class CloudScene {
 public:
  explicit CloudScene(const Eigen::Vector3d& eye_W = {0, -0.11, 0.62})
      : camera_(CameraIntrinsics(), LookAt(eye_W, {0, 0, 0.02}, Eigen::Vector3d::UnitZ())),
        depth_(camera_.intrinsics) {
    bin_.inner_size_m = {0.3, 0.3, 0.05};
    depth_.AddMesh(BinMesh(bin_), camera_.X_CW());
  }

  void AddBox(const Eigen::Vector3d& size_m, const Pose& X_WO) {
    depth_.AddMesh(BoxMesh(size_m, Eigen::Vector3d::Zero()), camera_.X_CW() * X_WO);
  }
  void AddMesh(const TriangleMesh& mesh_O, const Pose& X_WO) {
    depth_.AddMesh(mesh_O, camera_.X_CW() * X_WO);
  }

  const RgbdFrame& frame() const { return depth_.frame(); }
  const Camera& camera() const { return camera_; }
  const Bin& bin() const { return bin_; }
  // Input of a planner; `frame` replaces the exact image.
  PlannerInput Input(int max_grasps = 5) const {
    return {frame(), camera_.X_WC(), BinPlacement{bin_, Pose::Identity()}, {}, {}, max_grasps, 0};
  }

 private:
  Camera camera_;
  Bin bin_;
  SyntheticDepth depth_;
};

// Returns a pose on the floor of the bin with a rotation about z.
inline Pose OnFloor(double x_m, double y_m, double height_m, double yaw_rad) {
  return MakePose(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                  {x_m, y_m, 0.5 * height_m});
}

}  // namespace pickbed::tests
