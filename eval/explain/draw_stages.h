#pragma once

// Draws the stages of an estimate over its input image.

#include <string>
#include <vector>

#include "eval/draw/canvas.h"
#include "eval/draw/outline.h"
#include "perception/candidates/estimate_trace.h"
#include "scenes/base/ids.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval::explain {

inline constexpr Rgb8 kRight{70, 205, 95}, kNear{245, 185, 45}, kWrong{235, 62, 52};
inline constexpr Rgb8 kUnknown{85, 165, 255}, kPale{165, 170, 180};

// Enlarged image to draw on, and the camera that matches it.
struct Board {
  explicit Board(const RgbdFrame& frame);
  Eigen::Vector2d At(const Eigen::Vector2d& pixel) const;  // frame pixel -> board pixel

  int zoom = 1;
  CameraIntrinsics camera;  // intrinsics of the enlarged image
  Image<Rgb8> color;
  Image<Rgb8> faded;
};

// Foreground in its colours, the rest dimmed, pixels without a reading violet.
Image<Rgb8> DrawForeground(const RgbdFrame& frame, const OrganizedCloud& cloud);

struct ColoredDot {
  Eigen::Vector2d pixel;  // in the frame
  Rgb8 color;
};
// Draws dots of `radius_px` on the faded image of the board, with a legend.
Image<Rgb8> DrawDots(const Board& board, const std::vector<ColoredDot>& dots, double radius_px,
                     const std::vector<LegendEntry>& legend);

// Heat map of the object centers for which the patches vote. `centers` are in frame pixels and are
// smoothed with `sigma_px` (frame pixels). `rings` are drawn on top.
Image<Rgb8> DrawVoteMap(const Board& board, const std::vector<Eigen::Vector2d>& centers,
                        double sigma_px, const std::vector<ColoredDot>& rings,
                        const std::vector<LegendEntry>& legend);

struct DrawnPose {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  Rgb8 color;
  std::string label = {};  // drawn at its center of mass
  bool crossed = false;    // marked as wrong
};
// Draws the outlines of the poses. The first pose is on top.
Image<Rgb8> DrawPoses(const Board& board, ObjectOutlines& outlines, const ObjectSet& objects,
                      const std::vector<DrawnPose>& poses, const std::vector<LegendEntry>& legend);

}  // namespace pickbed::eval::explain
