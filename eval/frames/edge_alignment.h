#pragma once

// Compares the edges of a depth image with the edges of its color image.

#include <Eigen/Core>
#include <optional>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

// Reflections of the depth image.
enum class DepthFlip { kNone, kColumns, kRows, kBoth };

// Where the depth edges fit the color edges best.
struct EdgeAlignment {
  Eigen::Vector2d shift_px{0, 0};  // of the depth, at the principal point
  double scale = 1;                // of the depth about the principal point
  DepthFlip flip = DepthFlip::kNone;
  // Agreement of the edges where they are above its mean over all places, relative to the best
  // place: 1 = the depth fits best where it is, 0 = as anywhere. 0 for a reflection.
  double fit_here = 1;

  // Movement of a corner of the image to its best place, px.
  double CornerShift_px(const CameraIntrinsics& camera) const;
};

// Compares position and direction of the edges. Searches shifts up to 40 px and scales from 0.8 to
// 1.25. A scale other than 1 means that depth was registered with other intrinsics. Without a
// scale, the shift is refined to one pixel. If no place is clearly better than others, it searches
// reflected depth images. Returns nullopt if there is no clear place either, or if the frame has no
// color or few depth edges. Nothing can be said of such a frame.
std::optional<EdgeAlignment> AlignEdges(const RgbdFrame& frame);

}  // namespace pickbed::eval
