#pragma once

// Compares the edges of a depth image with the edges of its colour image.

#include <Eigen/Core>
#include <optional>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

// Where the depth edges fit the colour edges best.
struct EdgeAlignment {
  Eigen::Vector2d shift_px{0, 0};  // of the depth, at the principal point
  double scale = 1;                // of the depth about the principal point
  // Mean brightness gradient under the depth edges above the mean of all places, relative to the
  // best place: 1 = the depth fits best where it is, 0 = as anywhere.
  double fit_here = 1;

  // Movement of a corner of the image to its best place, px.
  double CornerShift_px(const CameraIntrinsics& camera) const;
};

// Searches shifts up to 40 px and scales from 0.8 to 1.25. A scale other than 1 means that depth
// was registered with other intrinsics. Without a scale, the shift is refined to one pixel. Returns
// nullopt if the frame has no colour, few depth edges or no place that is clearly better than
// others, so that nothing can be said.
std::optional<EdgeAlignment> AlignEdges(const RgbdFrame& frame);

}  // namespace pickbed::eval
