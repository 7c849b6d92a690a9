#pragma once

// The input of a completion: a depth image and the pixels that show one object.

#include <cmath>
#include <cstdint>
#include <optional>

#include "perception/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::perception {

// Fewer pixels with depth do not suffice for a completion.
inline constexpr int kMinSegmentPixels = 50;

// Returns whether a depth is a reading. 0, NaN, negative and infinite ones are none.
inline bool HasReading(float depth_m) { return depth_m > 0 && std::isfinite(depth_m); }

// A plane in the camera frame C: points with normal . p = offset_m.
struct FloorPlane {
  Eigen::Vector3f normal_C = -Eigen::Vector3f::UnitZ();  // unit, points away from the floor
  float offset_m = 0;
  float Height_m(const Eigen::Vector3f& p_C) const { return normal_C.dot(p_C) - offset_m; }
};

// The images have the size of the intrinsics. Any window of an image works as well, with the
// intrinsics of the window.
struct SegmentView {
  Image<float> depth_m;    // along camera z; see HasReading()
  Image<uint8_t> segment;  // not 0 = the pixel shows the object
  // Not 0 = the pixel shows something else, behind which the object may continue. Empty =
  // MarkOccluders() finds these pixels.
  Image<uint8_t> occluders;
  CameraIntrinsics intrinsics;
  std::optional<FloorPlane> floor;  // the object has no matter below it; absent = not known
};

// Returns the pixels outside the segment that are nearer than the nearest segment pixel in the
// image by more than `step_m`. Pixels farther from the segment than its largest extent in px are 0.
Image<uint8_t> MarkOccluders(const SegmentView& view, float step_m = 0.003f);

// Returns the number of segment pixels with a depth reading.
int SegmentPixels(const SegmentView& view);

// Throws InputError if the sizes of the images and the intrinsics differ, or if the segment has
// less than kMinSegmentPixels pixels with a reading.
void CheckSegmentView(const SegmentView& view);

}  // namespace pickbed::perception
