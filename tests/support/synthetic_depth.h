#pragma once

// Depth images of planes, spheres and meshes by ray casting: an independent, exact camera for tests
// of perception. Nothing here uses the renderer.

#include <vector>

#include "scenes/object_model.h"
#include "scenes/random.h"
#include "scenes/rgbd_frame.h"

namespace pickbed {

class SyntheticDepth {
 public:
  explicit SyntheticDepth(const CameraIntrinsics& intrinsics);

  void AddPlane(const Eigen::Vector3d& normal_C, const Eigen::Vector3d& point_C);
  void AddSphere(const Eigen::Vector3d& center_C, double radius_m);
  void AddMesh(const TriangleMesh& mesh_O, const Pose& X_CO);

  // Colourless; 0 where nothing was hit.
  const RgbdFrame& frame() const { return frame_; }

 private:
  void Offer(int x, int y, double depth_m);

  RgbdFrame frame_;
};

// 320x240 pixels at half the focal length of pickbed's usual camera.
CameraIntrinsics SmallCamera();

// Adds axial noise of sigma_m * z^2 to every reading.
RgbdFrame WithNoise(RgbdFrame frame, double sigma_m, Rng& rng);

TriangleMesh BoxMesh(const Eigen::Vector3d& size_m, const Eigen::Vector3d& center_O);

// An L with a boss off its middle, 60 x 24 x 40 mm: no symmetry, and every pose is held by its
// faces.
TriangleMesh BracketMesh();
// In C, with three of its sides in sight.
Pose BracketPose();

std::shared_ptr<const ObjectModel> ObjectOf(const TriangleMesh& mesh,
                                            const SymmetrySet& symmetries = {});

// Pose turned by angle_deg about an axis through the part's origin and moved.
Pose Perturbed(const Pose& X_CO, const Eigen::Vector3d& axis, double angle_deg,
               const Eigen::Vector3d& shift_m);

// Angle and shift of the origin between two poses.
struct PoseGap {
  double angle_deg, shift_m;
};
PoseGap GapBetween(const Pose& X_CA, const Pose& X_CB);

}  // namespace pickbed
