#pragma once

// Depth images of planes, spheres and meshes by ray casting: an independent, exact camera for tests
// of perception. It does not use the renderer.

#include <vector>

#include "scenes/base/random.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

class SyntheticDepth {
 public:
  explicit SyntheticDepth(const CameraIntrinsics& intrinsics);

  void AddPlane(const Eigen::Vector3d& normal_C, const Eigen::Vector3d& point_C);
  void AddSphere(const Eigen::Vector3d& center_C, double radius_m);
  void AddMesh(const TriangleMesh& mesh_O, const Pose& X_CO);

  // Depth without color; 0 where nothing was hit.
  const RgbdFrame& frame() const { return frame_; }

 private:
  void Offer(int x, int y, double depth_m);

  RgbdFrame frame_;
};

// Returns a camera with 320x240 pixels and half the focal length of the default camera.
CameraIntrinsics SmallCamera();

// Adds axial noise with sigma = sigma_m * z^2 to every reading.
RgbdFrame WithNoise(RgbdFrame frame, double sigma_m, Rng& rng);

TriangleMesh BoxMesh(const Eigen::Vector3d& size_m, const Eigen::Vector3d& center_O);

// Returns an L with a boss beside its center, 60 x 24 x 40 mm. It has no symmetry, and its faces
// constrain the pose in all directions.
TriangleMesh BracketMesh();
// Returns a pose of the bracket in C that shows three of its sides.
Pose BracketPose();

std::shared_ptr<const ObjectModel> ObjectOf(const TriangleMesh& mesh,
                                            const SymmetrySet& symmetries = {});

// Returns the pose rotated by angle_deg about an axis through the object's origin, then translated
// by shift_m.
Pose Perturbed(const Pose& X_CO, const Eigen::Vector3d& axis, double angle_deg,
               const Eigen::Vector3d& shift_m);

// Rotation angle and distance of the origins between two poses.
struct PoseGap {
  double angle_deg, shift_m;
};
PoseGap GapBetween(const Pose& X_CA, const Pose& X_CB);

}  // namespace pickbed::tests
