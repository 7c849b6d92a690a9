#include "grasp/plan/hidden_space.h"

#include <algorithm>
#include <cmath>

#include "scenes/camera/filled_depth.h"

namespace pickbed::grasp {

HiddenSpace::HiddenSpace(const Image<float>& depth_m, const CameraIntrinsics& intrinsics,
                         const Pose& X_CB, double behind_m)
    : depth_m_(FilledDepth(depth_m)), intrinsics_(intrinsics), X_CB_(X_CB), behind_m_(behind_m) {}

double HiddenSpace::HiddenVolume_m3(std::span<const AxisAlignedBox> boxes_G, const Pose& X_BG,
                                    double step_m) const {
  const Pose X_CG = X_CB_ * X_BG;
  double volume_m3 = 0;
  for (const AxisAlignedBox& box : boxes_G) {
    const Eigen::Array3d size_m = 2 * box.half_size.array();
    const Eigen::Array3i steps = (size_m / step_m).ceil().cast<int>().max(1);
    const Eigen::Array3d spacing_m = size_m / steps.cast<double>();
    const Eigen::Vector3d first_G = box.center - box.half_size + (0.5 * spacing_m).matrix();
    int hidden = 0;
    for (int x = 0; x < steps.x(); ++x) {
      for (int y = 0; y < steps.y(); ++y) {
        for (int z = 0; z < steps.z(); ++z) {
          const Eigen::Vector3d p_C =
              X_CG * (first_G + (Eigen::Array3d(x, y, z) * spacing_m).matrix());
          if (p_C.z() <= 0) continue;
          const Eigen::Vector2d pixel = Project(intrinsics_, p_C);
          const int u = static_cast<int>(std::lround(pixel.x()));
          const int v = static_cast<int>(std::lround(pixel.y()));
          if (!depth_m_.Contains(u, v)) continue;
          hidden += p_C.z() > depth_m_(u, v) + behind_m_;
        }
      }
    }
    volume_m3 += hidden * spacing_m.prod();
  }
  return volume_m3;
}

double HiddenSpace::MeanDepth_m(std::span<const AxisAlignedBox> sweep_G, const Pose& X_BG,
                                double step_m) const {
  double area_m2 = 0;
  for (size_t i = 0; i + 1 < sweep_G.size(); ++i) {  // the last is the palm
    area_m2 += 4 * sweep_G[i].half_size.x() * sweep_G[i].half_size.y();
  }
  if (area_m2 <= 0) return 0;
  return HiddenVolume_m3(sweep_G, X_BG, step_m) / area_m2;
}

}  // namespace pickbed::grasp
