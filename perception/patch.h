#pragma once

// Local patches of an image: what the descriptor network sees.
//
// A patch is a square of fixed physical side, cut around one pixel and perpendicular to the viewing
// ray through it, so that it looks the same wherever in the image and at whatever distance the part
// lies. Its frame P stands at the pixel's 3-D point, z along the viewing ray, x turned about the
// ray by the given in-plane angle. The first channel is depth along the ray relative to the centre
// over half the side, clipped to [-1, 1]; the others are the normal in P (x, y, z), or colour (red,
// green, blue, from -1 = 0 to 1 = 255). Pixels that are unknown or background have depth +1 (far)
// and 0 in the others, no normal or middle grey: a known bin is taken out. Values are stored as
// round(127 v). Scale by depth and colour as in Kehl et al., ECCV 2016; normals because grey adds
// nothing on bare metal.

#include <cstdint>
#include <span>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "scenes/image.h"
#include "scenes/pose.h"

namespace pickbed {

inline constexpr int kPatchPixels = 32;   // side, px
inline constexpr int kPatchChannels = 4;  // depth and three more, see PatchChannels
inline constexpr int kPatchArea = kPatchPixels * kPatchPixels;
inline constexpr int kPatchValues = kPatchChannels * kPatchArea;

enum class PatchChannels { kDepthNormals, kDepthColor };

// For people: "depth and normals", "depth and colour".
const char* NameOf(PatchChannels channels);

// Which patches are cut around a pixel.
struct PatchForm {
  double side_m = 0;
  PatchChannels channels = PatchChannels::kDepthNormals;
};

struct PatchSet {
  std::vector<int8_t> values;  // count x 4 x 32 x 32
  std::vector<Pose> X_CP;
  size_t size() const { return X_CP.size(); }
  std::span<const int8_t> patch(size_t i) const {
    return {values.data() + i * kPatchValues, static_cast<size_t>(kPatchValues)};
  }
};

// Side for a part: patch_diameters * diameter_m, rounded to the next power of sqrt(2) millimetres,
// so that parts of similar size share the patches of a query.
double PatchSide(double diameter_m, double patch_diameters);

// Frame of the patch around a point that the camera at the origin of C sees.
Pose PatchFrame(const Eigen::Vector3d& point_C, double angle_rad);

// Throws InputError where the frame of the cloud had no colour and the channels show it.
void RequireChannels(const OrganizedCloud& cloud, PatchChannels channels);

// One patch for each pixel index; each must have a point. Throws as RequireChannels() does.
PatchSet CutPatches(const OrganizedCloud& cloud, std::span<const int> pixels,
                    std::span<const double> angles_rad, const PatchForm& form);

// Whether a patch has nothing, or nothing near, at one of its kPatchArea pixels.
bool IsUnknownAt(std::span<const int8_t> patch, int pixel);

// What a patch of kDepthColor shows there.
Rgb8 PatchColorAt(std::span<const int8_t> patch, int pixel);

}  // namespace pickbed
