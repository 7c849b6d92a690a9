#include "perception/icp/projected_points.h"

#include <cstdint>
#include <cstring>

namespace pickbed::perception {
namespace {

// The compiler splits the vectors if the processor has narrower registers.
constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using Integers = int32_t __attribute__((vector_size(kLanes * sizeof(int32_t))));
static_assert(kMaxIcpPoints % kLanes == 0);

// A pose and a camera in single precision.
struct Motion {
  float R[3][3];
  float center[3];
  float f[2], c[2];  // focal lengths and principal point, px; the latter with half a pixel added
  int size[2];       // of the image, px
};

// A variant for AVX2 has no fused multiply-add, so that both variants round alike.
__attribute__((target_clones("avx2", "default"))) void ProjectAll(const IcpPoints& points,
                                                                  const Motion& motion,
                                                                  ProjectedPoints& projected) {
  for (int i = 0; i < points.count; i += kLanes) {
    Lanes point[3], normal[3], moved[3];
    for (int k = 0; k < 3; ++k) {
      std::memcpy(&point[k], &points.points[k][i], sizeof(Lanes));
      std::memcpy(&normal[k], &points.normals[k][i], sizeof(Lanes));
    }
    for (int k = 0; k < 3; ++k) {
      const float* const R = motion.R[k];
      // The products are added in the order of Eigen for one point.
      const Lanes arm = R[0] * point[0] + (R[1] * point[1] + R[2] * point[2]);
      const Lanes turned = R[0] * normal[0] + (R[1] * normal[1] + R[2] * normal[2]);
      moved[k] = arm + motion.center[k];
      std::memcpy(&projected.arms[k][i], &arm, sizeof(Lanes));
      std::memcpy(&projected.normals_C[k][i], &turned, sizeof(Lanes));
      std::memcpy(&projected.points_C[k][i], &moved[k], sizeof(Lanes));
    }
    // Comparisons are false for NaN. Other values outside the image are replaced before the
    // conversion, because huge values do not fit into an integer.
    Integers inside = moved[2] > 0;
    Integers pixel[2];
    for (int k = 0; k < 2; ++k) {
      const Lanes at = motion.f[k] * moved[k] / moved[2] + motion.c[k];
      inside &= (at >= 0) & (at < static_cast<float>(motion.size[k]));
      pixel[k] = __builtin_convertvector(inside ? at : Lanes{}, Integers);
    }
    const Integers index = inside ? pixel[1] * motion.size[0] + pixel[0] : Integers{} - 1;
    std::memcpy(&projected.pixels[i], &index, sizeof(Integers));
  }
}

}  // namespace

void ProjectPoints(const IcpPoints& points, const CenteredPose& pose,
                   const CameraIntrinsics& camera, ProjectedPoints& projected) {
  Motion motion;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) motion.R[i][k] = static_cast<float>(pose.R_CO(i, k));
    motion.center[i] = static_cast<float>(pose.center_C[i]);
  }
  motion.f[0] = static_cast<float>(camera.fx());
  motion.f[1] = static_cast<float>(camera.fy());
  motion.c[0] = static_cast<float>(camera.cx() + 0.5);
  motion.c[1] = static_cast<float>(camera.cy() + 0.5);
  motion.size[0] = camera.width();
  motion.size[1] = camera.height();
  ProjectAll(points, motion, projected);
}

}  // namespace pickbed::perception
