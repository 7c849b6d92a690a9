#pragma once

// Finds frames that cannot be what the user means: depth in another unit, a mesh in another unit,
// or color and depth of different images.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Diameters in the image (px) outside which no estimate is possible, and outside which it is
// unlikely to be good.
inline constexpr double kMinimumDiameter_px = 10, kGoodDiameter_px = 20;

// What a finding is about.
enum class FrameFault { kNoReadings, kRange, kFewReadings, kSize, kPrincipalPoint, kEdges };

struct FrameFinding {
  FrameFault fault = FrameFault::kNoReadings;
  bool is_error = false;  // else the frame is usable but doubtful
  std::string text;       // one line with the reason and a remedy
  // Movement of the color image after which its edges fit the depth edges; 0 = none is known.
  Eigen::Vector2i color_move_px{0, 0};
};

// Checks a frame against the objects that may be in it. `depth_scale_mm` is the scale with which
// the depth was read, for the remedy. Returns errors first:
// - no reading at all, or almost none
// - a median depth under 3 cm or over 15 m; doubtful under 10 cm or over 5 m
// - an object that is under 10 px wide at the nearest readings, or over twice the image at the
//   farthest; doubtful under 20 px or over the image
// - a principal point far from the center of the image (doubtful)
// - depth edges that fit the color edges elsewhere or reflected, see AlignEdges() (doubtful)
std::vector<FrameFinding> CheckFrame(const RgbdFrame& frame, const ObjectSet& objects,
                                     double depth_scale_mm);

// Moves the color image of a frame as its findings say. Pixels at the border are repeated, so that
// no edge arises.
void RegisterColor(const std::vector<FrameFinding>& findings, RgbdFrame& frame);

}  // namespace pickbed::eval
