#pragma once

// The pixels and the volume of a region of interest in one image.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "eval/layer.h"
#include "perception/pose_hypothesis.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/scenario/region_spec.h"

namespace pickbed::eval {

// Region of interest of one image.
struct ImageRegion {
  Image<uint8_t> pixels;      // 1 = in the region
  std::optional<Bounds> box;  // m, in its frame R; none = a mask
  Pose X_CR = Pose::Identity();
  bool is_depth_range = false;  // the box is only a range of depth

  // Edges of the box in the image, px; empty for a mask and for a depth range.
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> BoxLines(
      const CameraIntrinsics& camera) const;
};

// Returns the region of a frame. `X_CW`: pose of the world in the camera frame, if known. The
// automatic region begins where the largest object fills the image. It ends where its diameter is
// 40 px, but at least four diameters behind the nearest readings. Throws InputError for a box in an
// unknown world, and for a mask of another size than the image.
ImageRegion MakeRegion(const RegionSpec& spec, const RgbdFrame& frame,
                       const std::optional<Pose>& X_CW, const ObjectSet& objects);

// Returns whether a depth reading of the frame is in the region.
bool HasReadingIn(const ImageRegion& region, const RgbdFrame& frame);

// Throws InputError if no depth reading of the frame is in the region. The message has the region's
// `name` and the range of the readings.
void RequireReadingsIn(const ImageRegion& region, const RgbdFrame& frame, const std::string& name);

// Returns the region's pixels in a picture of another camera at the same pose.
Image<uint8_t> RegionInPicture(const ImageRegion& region, const CameraIntrinsics& camera,
                               const CameraIntrinsics& picture);

// Removes poses outside of the region. A pose is in a box if the center of the object is. It is in
// a mask if at least half of its vertices are seen there.
void KeepPosesIn(const ImageRegion& region, const CameraIntrinsics& camera,
                 const ObjectSet& objects, std::vector<PoseHypothesis>& poses);

}  // namespace pickbed::eval
