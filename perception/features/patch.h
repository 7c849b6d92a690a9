#pragma once

// Local image patches, the input of the descriptor network.
//
// A patch is a square with a fixed physical side, cut around one pixel and perpendicular to its
// viewing ray. Its appearance therefore does not depend on image position or distance. Frame P has
// its origin at the 3-D point of the pixel and z along the viewing ray. x is rotated about the ray
// by the in-plane angle, towards y. At angle 0, seen from the camera (z points away from it):
//
//   +-------+
//   |   P-->x
//   |   |   |
//   +---v---+
//       y
//
// Channel 0 is the depth along the ray relative to the origin of P, divided by half the side and
// clipped to [-1, 1]. Channels 1 to 3 are the normal in P (x, y, z), or color (red, green, blue;
// -1 = 0, 1 = 255). Unknown and background pixels have depth +1 (far) and 0 in channels 1 to 3,
// i.e. no normal or medium grey; this removes a known bin. Values are stored as round(127 v).
// Scaling by depth and the color channels follow Kehl et al., ECCV 2016. Normals are used because
// grey values add no information on bare metal.

#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "scenes/geometry/pose.h"
#include "scenes/image/image.h"

namespace pickbed::perception {

inline constexpr int kPatchPixels = 32;   // side, px
inline constexpr int kPatchChannels = 4;  // depth and three others, see PatchChannels
inline constexpr int kPatchArea = kPatchPixels * kPatchPixels;
inline constexpr int kPatchValues = kPatchChannels * kPatchArea;

// Channels 1 to 3 of a patch; channel 0 is always depth.
enum class PatchChannels { kDepthNormals, kDepthColor };

// Display name: "depth and normals" or "depth and color".
const char* NameOf(PatchChannels channels);

// Physical side and channels of a patch.
struct PatchForm {
  double side_m = 0;
  PatchChannels channels = PatchChannels::kDepthNormals;
};

// Patches with their frames in the camera frame.
struct PatchSet {
  std::vector<int8_t> values;  // count x 4 x 32 x 32
  std::vector<Pose> X_CP;
  size_t size() const { return X_CP.size(); }
  std::span<const int8_t> patch(size_t i) const {
    return {values.data() + i * kPatchValues, static_cast<size_t>(kPatchValues)};
  }
};

// Returns the patch side for an object, in metres: patch_diameters * diameter_m, rounded to the
// nearest power of sqrt(2) millimetres. Objects of similar size then share the patches of a query.
// Throws InputError if either argument is not positive.
double PatchSide(double diameter_m, double patch_diameters);

// Returns X_CP, the patch frame at a point that the camera sees.
Pose PatchFrame(const Eigen::Vector3d& point_C, double angle_rad);

// Throws InputError if the channels contain color and the cloud has none.
void RequireChannels(const OrganizedCloud& cloud, PatchChannels channels);

// Cuts one patch per pixel index; each pixel must have a point. `angles_rad` holds one in-plane
// angle per pixel. Throws as RequireChannels() does.
PatchSet CutPatches(const OrganizedCloud& cloud, std::span<const int> pixels,
                    std::span<const double> angles_rad, const PatchForm& form);

// Whether a patch has no reading, or only a far one, at a pixel (0 to kPatchArea - 1).
bool IsUnknownAt(std::span<const int8_t> patch, int pixel);

// Returns the color of a kDepthColor patch at a pixel.
Rgb8 PatchColorAt(std::span<const int8_t> patch, int pixel);

}  // namespace pickbed::perception
